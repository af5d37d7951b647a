// FastSLAM 1.0 as the thesis writes it (chapter 2, the equations as ../shared/THESIS.md corrects them), in
// plain numbers and with a kd-tree of descriptors in every particle: FastSlam with thesis_preset() must say
// the same.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fastslam/fastslam.hpp"
#include "fastslam/resampling.hpp"
#include "unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

// Nearest descriptor by bisection along one component after the other.
class DescriptorTree {
 public:
  using Entry = std::pair<Descriptor, std::size_t>;

  explicit DescriptorTree(std::vector<Entry> entries) : entries_(std::move(entries)) {
    split(0, entries_.size(), 0);
  }
  /// (landmark, squared distance); landmark of an empty tree is -1.
  std::pair<int, int> nearest(const Descriptor& query) const {
    std::pair<int, int> best(-1, std::numeric_limits<int>::max());
    search(query, 0, entries_.size(), 0, best);
    return best;
  }

 private:
  void split(std::size_t from, std::size_t to, std::size_t axis) {
    if (to - from < 2) return;
    const auto at = [&](std::size_t i) { return entries_.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::size_t middle = (from + to) / 2;
    std::nth_element(at(from), at(middle), at(to),
                     [axis](const Entry& a, const Entry& b) { return a.first[axis] < b.first[axis]; });
    split(from, middle, (axis + 1) % 64);
    split(middle + 1, to, (axis + 1) % 64);
  }
  void search(const Descriptor& query, std::size_t from, std::size_t to, std::size_t axis,
              std::pair<int, int>& best) const {
    if (from >= to) return;
    const std::size_t middle = (from + to) / 2;
    const int d2 = squared_distance(query, entries_[middle].first);
    if (d2 < best.second) best = {static_cast<int>(entries_[middle].second), d2};
    const int side = query[axis] - entries_[middle].first[axis];
    const std::size_t next = (axis + 1) % 64;
    if (side < 0) search(query, from, middle, next, best);
    if (side >= 0) search(query, middle + 1, to, next, best);
    if (side * side > best.second) return;
    if (side < 0) search(query, middle + 1, to, next, best);
    if (side >= 0) search(query, from, middle, next, best);
  }
  std::vector<Entry> entries_;
};

struct ThesisLandmark {
  Eigen::Vector3d mean;
  Eigen::Matrix3d Sigma;
  Descriptor descriptor;
};

struct ThesisParticle {
  double x = 0, y = 0, theta = 0, weight = 0;
  std::vector<ThesisLandmark> landmarks;
};

struct Observation {
  Eigen::Vector3d z;  // robot coordinates
  Eigen::Matrix3d R;
  Descriptor descriptor;
};

// 2.6-2.8 and their derivative by the landmark.
Eigen::Vector3d h(const ThesisParticle& p, const Eigen::Vector3d& m) {
  const double dx = m.x() - p.x, dy = m.y() - p.y, c = std::cos(p.theta), s = std::sin(p.theta);
  return {dx * c + dy * s, -dx * s + dy * c, m.z()};
}
Eigen::Matrix3d G(const ThesisParticle& p) {
  const double c = std::cos(p.theta), s = std::sin(p.theta);
  Eigen::Matrix3d J;
  J << c, s, 0, -s, c, 0, 0, 0, 1;
  return J;
}

class ThesisFilter {
 public:
  explicit ThesisFilter(const FastSlamSettings& s)
      : settings_(s),
        particles_(static_cast<std::size_t>(s.particles)),
        resampling_(s.seed, 0x726573616d706c65) {  // FastSlam's stream for resampling
    for (std::size_t k = 0; k < particles_.size(); ++k) streams_.emplace_back(s.seed, k);
  }

  void step(const Eigen::Isometry3d& motion, const std::vector<Observation>& observations) {
    const double largest = std::pow(127 * settings_.descriptor_distance, 2);
    std::vector<Observation> fresh;
    if (started_) {
      std::vector<std::vector<char>> rejected(particles_.size(), std::vector<char>(observations.size(), 0));
      for (std::size_t k = 0; k < particles_.size(); ++k) {
        ThesisParticle& p = particles_[k];
        sample(motion, p, streams_[k]);
        std::vector<DescriptorTree::Entry> entries;
        for (std::size_t i = 0; i < p.landmarks.size(); ++i)
          entries.emplace_back(p.landmarks[i].descriptor, i);
        const DescriptorTree tree(entries);
        p.weight = 1;
        for (std::size_t o = 0; o < observations.size(); ++o) {
          const auto [landmark, distance2] = tree.nearest(observations[o].descriptor);
          if (distance2 > largest) {
            if (k == 0) fresh.push_back(observations[o]);  // new to all particles alike
          } else if (!update(observations[o], p.landmarks[static_cast<std::size_t>(landmark)], p)) {
            rejected[k][o] = 1;
          }
        }
      }
      const std::size_t best = best_particle();
      for (std::size_t o = 0; o < observations.size(); ++o)
        if (rejected[best][o]) fresh.push_back(observations[o]);
    } else {
      fresh = observations;
      for (ThesisParticle& p : particles_) p.weight = 1;
    }
    started_ = true;
    best_ = particles_[best_particle()];
    for (ThesisParticle& p : particles_)
      for (const Observation& o : fresh) p.landmarks.push_back(initialise(o, p));
    resample_all();
  }

  const std::vector<ThesisParticle>& particles() const { return particles_; }
  const ThesisParticle& best() const { return best_; }

 private:
  void sample(const Eigen::Isometry3d& motion, ThesisParticle& p, Random& random) const {
    // The order of the draws is FastSlam's: x, y, heading, in the frame of the robot that has moved.
    const double dx = settings_.translation_noise * random.normal();
    const double dy = settings_.translation_noise * random.normal();
    const double turn = settings_.rotation_noise * random.normal();
    const Eigen::Isometry3d T =
        planar_pose(p.x, p.y, p.theta) * motion * se3_exp((Vector6d() << dx, dy, 0, 0, 0, turn).finished());
    p.x = T.translation().x();
    p.y = T.translation().y();
    p.theta = yaw(T);
  }

  // Gate and weight by 2.5 (corrected), update by the extended Kalman filter; false: rejected.
  bool update(const Observation& o, ThesisLandmark& m, ThesisParticle& p) const {
    const Eigen::Matrix3d J = G(p), S = J * m.Sigma * J.transpose() + o.R;
    const Eigen::Vector3d v = o.z - h(p, m.mean);
    const double likeness = std::exp(-0.5 * v.dot(S.inverse() * v));
    if (likeness < settings_.gate) {
      p.weight *= settings_.p0;
      return false;
    }
    p.weight *= likeness / std::sqrt((2 * M_PI * S).determinant());
    const Eigen::Matrix3d K = m.Sigma * J.transpose() * S.inverse();
    m.mean += K * v;
    m.Sigma = (Eigen::Matrix3d::Identity() - K * J) * m.Sigma;
    return true;
  }

  ThesisLandmark initialise(const Observation& o, const ThesisParticle& p) const {
    const double c = std::cos(p.theta), s = std::sin(p.theta);
    ThesisLandmark m;
    m.mean << o.z.x() * c - o.z.y() * s + p.x, o.z.x() * s + o.z.y() * c + p.y, o.z.z();  // 2.1-2.3
    m.Sigma = (G(p).transpose() * o.R.inverse() * G(p)).inverse();                        // 2.4 corrected
    m.descriptor = o.descriptor;
    return m;
  }

  std::size_t best_particle() const {
    return static_cast<std::size_t>(
        std::max_element(particles_.begin(), particles_.end(),
                         [](const auto& a, const auto& b) { return a.weight < b.weight; }) -
        particles_.begin());
  }

  void resample_all() {
    std::vector<double> weights;
    double sum = 0;
    for (const ThesisParticle& p : particles_) sum += p.weight;
    for (const ThesisParticle& p : particles_) weights.push_back(p.weight / sum);
    std::vector<ThesisParticle> next;
    for (const int a : resample(weights, settings_.resampling, resampling_))
      next.push_back(particles_[static_cast<std::size_t>(a)]);
    particles_ = std::move(next);
  }

  FastSlamSettings settings_;
  std::vector<ThesisParticle> particles_;
  ThesisParticle best_;
  std::vector<Random> streams_;
  Random resampling_;
  bool started_ = false;
};

std::vector<Observation> observations_of(const FeatureFrame& frame, const FastSlamSettings& settings) {
  std::vector<Observation> result;
  for (const FeaturePoint& p : usable_features(frame, settings))
    result.push_back({p.measurement.value, p.measurement.covariance,
                      frame.features[static_cast<std::size_t>(p.feature)].descriptor});
  return result;
}

class Thesis : public testing::TestWithParam<ResamplingScheme> {};

// The deviation: landmarks by id and not by a kd-tree in every particle. With known correspondences (here: no
// two landmarks look alike, no wrong matches) poses, weights and maps are equal.
TEST_P(Thesis, ByIdEqualsAKdTreeInEveryParticle) {
  int rejected = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    synthetic::WorldSettings world;
    world.frames = 30;
    world.landmarks = 250;
    world.wrong_match = world.clutter = 0;
    world.descriptor_noise = 0.02;
    world.slips = false;
    world.wiggle = 0;
    world.scale_error = world.rotation_error = 0.005;
    FastSlamSettings settings = thesis_preset();
    settings.particles = 15;
    settings.seed = seed;
    settings.resampling = GetParam();
    settings.gate =
        1e-9;         // nobody is rejected: a rejected feature makes a landmark that looks like the old one
    settings.p0 = 1;  // so that a product of densities stays within doubles in either direction
    FastSlam slam(settings);
    ThesisFilter thesis(settings);
    for (const auto& step : synthetic::make_drive(world, seed).steps) {
      const StepResult r = slam.step(step.motion, step.frame);
      thesis.step(restrict_pose(step.motion.T_from_to, true), observations_of(step.frame, settings));
      rejected += r.rejected;

      ASSERT_NEAR(r.T_world_robot.translation().x(), thesis.best().x, 1e-6) << step.frame.seq;
      ASSERT_NEAR(r.T_world_robot.translation().y(), thesis.best().y, 1e-6) << step.frame.seq;
      for (std::size_t k = 0; k < thesis.particles().size(); ++k) {
        const ThesisParticle& p = thesis.particles()[k];
        const Particle& q = slam.particles()[k];
        ASSERT_NEAR(q.T_world_robot.translation().x(), p.x, 1e-6) << step.frame.seq << " particle " << k;
        ASSERT_NEAR(q.T_world_robot.translation().y(), p.y, 1e-6) << step.frame.seq << " particle " << k;
        ASSERT_NEAR(std::remainder(yaw(q.T_world_robot) - p.theta, 2 * M_PI), 0, 1e-7);
        ASSERT_EQ(slam.index().size(), static_cast<int>(p.landmarks.size())) << step.frame.seq;
      }
    }
    // Every landmark of every particle, found by its descriptor.
    for (std::size_t k = 0; k < thesis.particles().size(); ++k)
      for (const ThesisLandmark& m : thesis.particles()[k].landmarks) {
        int slot = 0;
        while (slam.index().descriptor(slot) != m.descriptor) ASSERT_LT(++slot, slam.index().slots());
        const LandmarkGaussian& n = *slam.particles()[k].map.find(static_cast<std::size_t>(slot));
        ASSERT_LT((n.mean - m.mean).norm(), 1e-6);
        ASSERT_LT((n.covariance - m.Sigma).norm(), 1e-6 * m.Sigma.norm());
      }
  }
  EXPECT_EQ(rejected, 0);
}

INSTANTIATE_TEST_SUITE_P(Schemes, Thesis,
                         testing::Values(ResamplingScheme::multinomial, ResamplingScheme::systematic,
                                         ResamplingScheme::stratified, ResamplingScheme::residual));

}  // namespace
}  // namespace lcmslam

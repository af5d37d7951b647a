#pragma once
// FastSLAM 1.0 as the thesis writes it (section 2.3.2, equations as docs/THESIS.md corrects them), in
// plain numbers: every particle owns its landmarks with their descriptors, in kd-trees of its own that are
// copied when it is drawn. Nothing is shared and no landmark has an id beyond its particle. What FastSlam
// with thesis_preset() must equal.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include <lcmslam/fastslam/resampling.hpp>
#include "tests/unit/fastslam/descriptor_tree.hpp"

namespace lcmslam::testing {

struct ThesisLandmark {
  Eigen::Vector3d mean;   // m, world
  Eigen::Matrix3d Sigma;  // m^2
};

struct ThesisParticle {
  double x = 0, y = 0, theta = 0;
  double log_weight = 0;  // a product of densities leaves the range of doubles
  std::vector<ThesisLandmark> landmarks;
  DescriptorTree trees[2];  // of each Laplacian sign

  void rotation(double& c, double& s) const { c = std::cos(theta), s = std::sin(theta); }
  // 2.6-2.8: a place in the world as the robot should measure it.
  Eigen::Vector3d measured(const Eigen::Vector3d& m) const {
    double c = 0, s = 0;
    rotation(c, s);
    return {(m.x() - x) * c + (m.y() - y) * s, -(m.x() - x) * s + (m.y() - y) * c, m.z()};
  }
  // 2.1-2.3: a measurement in the world.
  Eigen::Vector3d placed(const Eigen::Vector3d& z) const {
    double c = 0, s = 0;
    rotation(c, s);
    return {z.x() * c - z.y() * s + x, z.x() * s + z.y() * c + y, z.z()};
  }
  // The derivative of 2.6-2.8 by the landmark.
  Eigen::Matrix3d G() const {
    double c = 0, s = 0;
    rotation(c, s);
    return (Eigen::Matrix3d() << c, s, 0, -s, c, 0, 0, 0, 1).finished();
  }
};

struct ThesisObservation {
  Eigen::Vector3d z;  // m, robot frame
  Eigen::Matrix3d R;  // m^2
  Descriptor descriptor;
  bool dark = false;  // sign of the Laplacian
};

struct ThesisSettings {
  int particles = 100;
  std::uint64_t seed = 1;
  double sigma_r = 0.05, sigma_theta = 0.01;  // m and rad a step, figure 2.1
  double gate = 0.003, p0 = 1e-3;             // of exp(-d^2/2); weight of a rejected observation
  double descriptor_distance = 0.5;           // what is farther is new
  ResamplingScheme resampling = ResamplingScheme::multinomial;
  bool resample = true;  // in every step
};

class ThesisFilter {
 public:
  explicit ThesisFilter(const ThesisSettings& settings)
      : settings_(settings),
        particles_(static_cast<std::size_t>(settings.particles)),
        drawing_(settings.seed, 0x726573616d706c65) {  // FastSlam's stream for resampling
    for (std::size_t k = 0; k < particles_.size(); ++k) streams_.emplace_back(settings.seed, k);
  }

  /// Motion of the robot in its own frame since the last step: m, m, rad. Ignored in the first.
  void step(const Eigen::Vector3d& motion, const std::vector<ThesisObservation>& observations) {
    std::vector<std::vector<char>> accepted(particles_.size(), std::vector<char>(observations.size(), 0));
    for (std::size_t k = 0; started_ && k < particles_.size(); ++k) {
      move(motion, streams_[k], particles_[k]);
      accepted[k] = observe(observations, particles_[k]);
    }
    started_ = true;
    // What the best particle did not recognise is new to all.
    best_ = static_cast<std::size_t>(
        std::max_element(particles_.begin(), particles_.end(),
                         [](const auto& a, const auto& b) { return a.log_weight < b.log_weight; }) -
        particles_.begin());
    for (ThesisParticle& particle : particles_)
      for (std::size_t o = 0; o < observations.size(); ++o)
        if (!accepted[best_][o]) initialise(observations[o], particle);
    accepted_ = static_cast<int>(std::count(accepted[best_].begin(), accepted[best_].end(), 1));
    T_best_ = {particles_[best_].x, particles_[best_].y, particles_[best_].theta};
    draw();
  }

  const std::vector<ThesisParticle>& particles() const { return particles_; }
  /// Of the last step, before the drawing.
  const Eigen::Vector3d& best_pose() const { return T_best_; }
  double effective_particles() const { return effective_; }
  int accepted() const { return accepted_; }

 private:
  // Noise on the robot's way, in the frame of the robot that has moved: x, y and heading as one SE(2)
  // exponential, drawn in this order.
  void move(const Eigen::Vector3d& motion, Random& random, ThesisParticle& p) const {
    go(motion, p);
    const double forward = settings_.sigma_r * random.normal();
    const double left = settings_.sigma_r * random.normal();
    const double turn = settings_.sigma_theta * random.normal();
    const double a = std::sin(turn) / turn, b = (1 - std::cos(turn)) / turn;
    go({a * forward - b * left, b * forward + a * left, turn}, p);
  }
  static void go(const Eigen::Vector3d& motion, ThesisParticle& p) {
    const Eigen::Vector3d to = p.placed({motion.x(), motion.y(), 0});
    p.x = to.x(), p.y = to.y(), p.theta += motion.z();
  }

  // Every observation seeks the landmark in the particle's own trees that looks most like it; a landmark
  // takes the one observation that looks most like it. Gate and weight by 2.5.
  std::vector<char> observe(const std::vector<ThesisObservation>& observations, ThesisParticle& p) const {
    const double largest = std::pow(127 * settings_.descriptor_distance, 2);
    std::vector<DescriptorTree::Nearest> claims(p.landmarks.size());  // by landmark; .landmark: observation
    for (std::size_t o = 0; o < observations.size(); ++o) {
      const auto found = p.trees[observations[o].dark].nearest(observations[o].descriptor);
      if (found.landmark < 0 || found.distance2 > largest) continue;
      DescriptorTree::Nearest& claim = claims[static_cast<std::size_t>(found.landmark)];
      if (found.distance2 < claim.distance2) claim = {static_cast<int>(o), found.distance2};
    }
    std::vector<char> accepted(observations.size(), 0);
    for (std::size_t m = 0; m < claims.size(); ++m) {
      if (claims[m].landmark < 0) continue;
      const auto o = static_cast<std::size_t>(claims[m].landmark);
      accepted[o] = update(observations[o], p.landmarks[m], p);
    }
    return accepted;
  }

  bool update(const ThesisObservation& o, ThesisLandmark& m, ThesisParticle& p) const {
    const Eigen::Matrix3d G = p.G(), S = G * m.Sigma * G.transpose() + o.R;
    const Eigen::Vector3d v = o.z - p.measured(m.mean);
    const double half_d2 = 0.5 * v.dot(S.inverse() * v);
    if (std::exp(-half_d2) < settings_.gate) {
      p.log_weight += std::log(settings_.p0);
      return false;
    }
    p.log_weight += -half_d2 - 0.5 * std::log((2 * M_PI * S).determinant());
    const Eigen::Matrix3d K = m.Sigma * G.transpose() * S.inverse();
    m.mean += K * v;
    m.Sigma = ((Eigen::Matrix3d::Identity() - K * G) * m.Sigma).eval();
    return true;
  }

  static void initialise(const ThesisObservation& o, ThesisParticle& p) {
    p.trees[o.dark].insert(o.descriptor, static_cast<int>(p.landmarks.size()));
    p.landmarks.push_back({p.placed(o.z), (p.G().transpose() * o.R.inverse() * p.G()).inverse()});  // 2.4
  }

  void draw() {
    std::vector<double> weights;
    double sum = 0, squares = 0;
    const double highest = particles_[best_].log_weight;
    for (ThesisParticle& p : particles_) {
      p.log_weight -= highest;
      sum += std::exp(p.log_weight);
    }
    for (const ThesisParticle& p : particles_) {
      weights.push_back(std::exp(p.log_weight) / sum);
      squares += weights.back() * weights.back();
    }
    effective_ = 1 / squares;
    if (!settings_.resample) return;
    std::vector<ThesisParticle> drawn;
    for (const int ancestor : resample(weights, settings_.resampling, drawing_)) {
      drawn.push_back(particles_[static_cast<std::size_t>(ancestor)]);
      drawn.back().log_weight = 0;
    }
    particles_ = std::move(drawn);
  }

  ThesisSettings settings_;
  std::vector<ThesisParticle> particles_;
  std::vector<Random> streams_;  // FastSlam's: one a particle
  Random drawing_;
  std::size_t best_ = 0;
  Eigen::Vector3d T_best_ = Eigen::Vector3d::Zero();
  double effective_ = 0;
  int accepted_ = 0;
  bool started_ = false;
};

}  // namespace lcmslam::testing

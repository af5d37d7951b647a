// FastSlam with thesis_preset() against the thesis's filter as written (thesis_filter.hpp): the one
// deviation, landmarks found by a shared id instead of by a kd-tree in every particle, changes nothing.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>
#include <sstream>
#include <string>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tests/support/recordings.hpp"
#include "tests/unit/fastslam/synthetic_world.hpp"
#include "tests/unit/fastslam/thesis_filter.hpp"
#include "tests/unit/odometry/tum_recording.hpp"

namespace lcmslam {
namespace {

using testing::ThesisFilter;
using testing::ThesisObservation;
using testing::ThesisParticle;
using testing::ThesisSettings;

// The same choices for both.
ThesisSettings as_written(const FastSlamSettings& s) {
  ThesisSettings t;
  t.particles = s.particles;
  t.seed = s.seed;
  t.resampling = s.resampling;
  t.resample = s.resample_fraction > 0;
  return t;
}

std::vector<ThesisObservation> observations_of(const FeatureFrame& frame, const FastSlamSettings& settings) {
  std::vector<ThesisObservation> result;
  for (const FeaturePoint& p : usable_features(frame, settings)) {
    const Feature& feature = frame.features[static_cast<std::size_t>(p.feature)];
    result.push_back(
        {p.measurement.value, p.measurement.covariance, feature.descriptor, feature.laplacian >= 0});
  }
  return result;
}

// Of everything that a particle holds; descriptors exactly. FastSlam keeps covariances in floats
// (CompactLandmark), each right to 6e-8 after every update.
std::string difference(const Particle& ours, const ThesisParticle& thesis, const LandmarkIndex& index) {
  constexpr double metres = 1e-6, radians = 1e-6, ratio = 1e-5;
  std::ostringstream text;
  const auto& T = ours.T_world_robot;
  if (std::hypot(T.translation().x() - thesis.x, T.translation().y() - thesis.y) > metres ||
      std::abs(std::remainder(yaw(T) - thesis.theta, 2 * M_PI)) > radians)
    text << "pose " << T.translation().head<2>().transpose() << " " << yaw(T) << " is " << thesis.x << " "
         << thesis.y << " " << thesis.theta;
  else if (std::abs(ours.log_weight - thesis.log_weight) > ratio * (1 + std::abs(thesis.log_weight)))
    text << "log weight " << ours.log_weight << " is " << thesis.log_weight;
  else if (index.size() != static_cast<int>(thesis.landmarks.size()))
    text << index.size() << " landmarks are " << thesis.landmarks.size();
  for (std::size_t m = 0; text.str().empty() && m < thesis.landmarks.size(); ++m) {
    const LandmarkGaussian& landmark = *ours.map.find(m);  // slots count up: nothing dies
    const auto& [mean, Sigma] = thesis.landmarks[m];
    const auto same = thesis.trees[index.search().is_dark(static_cast<int>(m))].nearest(
        index.descriptor(static_cast<int>(m)));
    if ((landmark.mean - mean).norm() > metres || (landmark.covariance - Sigma).norm() > ratio * Sigma.norm())
      text << "landmark " << m << " at " << landmark.mean.transpose() << " is at " << mean.transpose();
    else if (same.distance2 != 0)
      text << "landmark " << m << " has another descriptor";
  }
  return text.str();
}

// Both filters side by side; counts tell that something was at stake.
struct Comparison {
  FastSlamSettings settings;
  FastSlam slam{settings};
  ThesisFilter thesis;
  int frames = 0, accepted = 0, rejected = 0, created = 0;
  double effective = 0;  // particles, summed

  explicit Comparison(const FastSlamSettings& s) : Comparison(s, as_written(s)) {}
  Comparison(const FastSlamSettings& s, const ThesisSettings& t) : settings(s), thesis(t) {}

  /// What differs after a step; empty when nothing does.
  std::string step(const Motion& motion, const FeatureFrame& frame) {
    const StepResult r = slam.step(motion, frame);
    const Eigen::Isometry3d& T = motion.T_from_to;
    thesis.step({T.translation().x(), T.translation().y(), yaw(T)}, observations_of(frame, settings));
    ++frames;
    accepted += r.used;
    rejected += r.rejected;
    created += r.created;
    effective += r.effective_sample_size;
    std::ostringstream text;
    const Eigen::Vector3d best(r.T_world_robot.translation().x(), r.T_world_robot.translation().y(),
                               yaw(r.T_world_robot));
    const Eigen::Vector3d off = best - thesis.best_pose();
    if (off.head<2>().norm() > 1e-6 || std::abs(std::remainder(off.z(), 2 * M_PI)) > 1e-6)
      text << "best pose " << best.transpose() << " is " << thesis.best_pose().transpose();
    else if (std::abs(r.effective_sample_size / thesis.effective_particles() - 1) > 1e-5)
      text << r.effective_sample_size << " effective particles are " << thesis.effective_particles();
    else if (r.used != thesis.accepted())
      text << r.used << " accepted are " << thesis.accepted();
    for (std::size_t k = 0; text.str().empty() && k < thesis.particles().size(); ++k)
      if (const auto d = difference(slam.particles()[k], thesis.particles()[k], slam.index()); !d.empty())
        text << "particle " << k << ": " << d;
    return text.str().empty() ? "" : "frame " + std::to_string(frames) + ": " + text.str();
  }
};

/// A sensor that is good enough leaves one particle alive and little to draw: here it is a poor one.
FastSlamSettings small_thesis(std::uint64_t seed, double inflation = 50) {
  FastSlamSettings settings = thesis_preset();
  settings.particles = 15;
  settings.measurement_inflation = inflation;
  settings.measurement_sigma = 0;  // as this world's sensor errs
  settings.seed = seed;
  return settings;
}

/// The way round half a lap with slips, wrong matches, clutter and a systematic range error.
synthetic::Drive drive(std::uint64_t seed, int frames = 40) {
  synthetic::WorldSettings world;
  world.landmarks = 400;
  world.frames = frames;
  world.frame_seconds = 0.25;
  return make_drive(world, seed);
}

class Thesis : public ::testing::TestWithParam<ResamplingScheme> {};

TEST_P(Thesis, ByIdEqualsAKdTreeInEveryParticle) {
  for (const double inflation : {1., 50.}) {
    SCOPED_TRACE(inflation);
    FastSlamSettings settings = small_thesis(static_cast<std::uint64_t>(inflation), inflation);
    settings.resampling = GetParam();
    Comparison both(settings);
    for (const auto& step : drive(settings.seed).steps) ASSERT_EQ(both.step(step.motion, step.frame), "");
    EXPECT_GT(both.accepted, 5 * both.frames);
    EXPECT_GT(both.rejected, both.frames);
    EXPECT_GT(both.created, 300);
    EXPECT_GT(both.effective, (inflation > 1 ? 2 : 1) * both.frames);
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, Thesis,
                         ::testing::Values(ResamplingScheme::multinomial, ResamplingScheme::systematic,
                                           ResamplingScheme::stratified, ResamplingScheme::residual));

// Every particle's own weight is there to be seen when none is drawn.
TEST(ThesisFilter, WeightsAreEqualInEveryParticle) {
  FastSlamSettings settings = small_thesis(4);
  settings.resample_fraction = 0;
  Comparison both(settings);
  for (const auto& step : drive(4, 40).steps) ASSERT_EQ(both.step(step.motion, step.frame), "");
  std::set<double> weights;
  for (const Particle& particle : both.slam.particles()) weights.insert(particle.log_weight);
  EXPECT_EQ(weights.size(), both.slam.particles().size()) << "no two are alike";
}

// Images of a hand-held camera that the planar filter follows badly: much is rejected and made anew.
TEST(ThesisFilter, EqualOnARecording) {
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  testing::TumRecording recording(recording_path("tum_fr1_rpy"));
  Comparison both(small_thesis(5));
  for (std::size_t i = 0; i < 10; ++i) ASSERT_EQ(both.step(Motion(), recording.features(i)), "");
  EXPECT_GT(both.accepted, 10 * both.frames);
  EXPECT_GT(both.rejected, both.frames);
}

// The comparison notices each thing in which the two might differ.
TEST(ThesisFilter, ComparisonNoticesEveryDifference) {
  const auto steps = drive(6, 25).steps;
  FastSlamSettings settings = small_thesis(6);
  const auto differ = [&](const std::function<void(ThesisSettings&)>& change) {
    ThesisSettings other = as_written(settings);
    change(other);
    Comparison both(settings, other);
    for (const auto& step : steps)
      if (!both.step(step.motion, step.frame).empty()) return true;
    return false;
  };
  const auto nothing = [](ThesisSettings&) {};
  EXPECT_FALSE(differ(nothing));
  EXPECT_TRUE(differ([](ThesisSettings& t) { t.gate *= 1.5; }));
  EXPECT_TRUE(differ([](ThesisSettings& t) { t.p0 *= 1.5; }));
  EXPECT_TRUE(differ([](ThesisSettings& t) { t.sigma_r *= 1.001; }));
  EXPECT_TRUE(differ([](ThesisSettings& t) { t.descriptor_distance = 0.28; }));
  EXPECT_TRUE(differ([](ThesisSettings& t) { t.resampling = ResamplingScheme::systematic; }));
  settings.guided = true;  // the modern search: a landmark is sought only where the best particle expects it
  EXPECT_TRUE(differ(nothing));
}

}  // namespace
}  // namespace lcmslam

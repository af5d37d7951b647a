// The same bytes for the same input.

#include <gtest/gtest.h>

#include <memory>
#include <opencv2/core/utility.hpp>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

using synthetic::Drive;
using synthetic::make_drive;
using synthetic::short_world;

bool same_bytes(const FastSlam& a, const FastSlam& b) {
  for (std::size_t k = 0; k < a.particles().size(); ++k) {
    if (a.particles()[k].T_world_robot.matrix() != b.particles()[k].T_world_robot.matrix()) return false;
    if (a.particles()[k].log_weight != b.particles()[k].log_weight) return false;
  }
  const auto p = a.landmarks(), q = b.landmarks();
  if (p.size() != q.size()) return false;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p[i].id != q[i].id || p[i].mean != q[i].mean || p[i].covariance != q[i].covariance) return false;
  return true;
}

TEST(FastSlam, SameSeedSameBytesOtherSeedOtherBytes) {
  const Drive drive = make_drive(short_world(40), 5);
  FastSlamSettings settings;
  FastSlam a(settings), b(settings);
  settings.seed = 2;
  FastSlam c(settings);
  for (const auto& step : drive.steps) {
    a.step(step.motion, step.frame);
    b.step(step.motion, step.frame);
    c.step(step.motion, step.frame);
  }
  EXPECT_TRUE(same_bytes(a, b));
  EXPECT_FALSE(same_bytes(a, c));
}

// Every observation counts, and there are enough particles, so that threads share the work.
TEST(FastSlam, ThreadsDoNotMatter) {
  const Drive drive = make_drive(short_world(60), 5);
  const int before = cv::getNumThreads();
  FastSlamSettings settings;
  settings.particles = 150;
  std::vector<std::unique_ptr<FastSlam>> slams;
  for (const int threads : {1, 2, 4}) {
    cv::setNumThreads(threads);
    FastSlam& slam = *slams.emplace_back(std::make_unique<FastSlam>(settings));
    Drive shuffled = drive;
    Random random(static_cast<std::uint64_t>(threads));
    for (auto& step : shuffled.steps) {
      auto& features = step.frame.features;
      for (std::size_t i = features.size(); i > 1; --i) std::swap(features[i - 1], features[random.below(i)]);
      slam.step(step.motion, step.frame);
    }
  }
  cv::setNumThreads(before);
  ASSERT_GT(slams[0]->landmarks().size(), 100u);
  EXPECT_TRUE(same_bytes(*slams[0], *slams[1]));
  EXPECT_TRUE(same_bytes(*slams[0], *slams[2]));
}

TEST(FastSlam, OrderOfFeaturesDoesNotMatter) {
  for (const bool thesis : {false, true}) {
    const FastSlamSettings settings = thesis ? thesis_preset() : FastSlamSettings();
    FastSlam a(settings), b(settings);
    Random random(1);
    for (const auto& step : make_drive(short_world(25), 6).steps) {
      a.step(step.motion, step.frame);
      FeatureFrame shuffled = step.frame;
      for (std::size_t i = shuffled.features.size(); i > 1; --i)
        std::swap(shuffled.features[i - 1], shuffled.features[static_cast<std::size_t>(random.below(i))]);
      b.step(step.motion, shuffled);
    }
    EXPECT_TRUE(same_bytes(a, b));
  }
}

}  // namespace
}  // namespace lcmslam

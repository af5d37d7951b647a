// Features that straddle an edge of depth.

#include <lcmslam/rgbd/feature_support.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/analytic_scene.hpp"

namespace lcmslam {
namespace {

constexpr double step = 0.05;

/// A wall 2 m away and a board before its right half, 1.5 m away, seen by a head whose cameras
/// stand apart; the depth image was taken elsewhere than the colour image.
class FeatureSupport : public testing::Test {
 protected:
  FeatureSupport() {
    T_colour_depth_time_ = se3_exp((Vector6d() << 0.02, -0.01, 0.01, 0.01, -0.03, 0.02).finished());
    scene_.planes = {{{0, 0, 1}, 2}};
    scene_.boxes = {{Eigen::Vector3d(0.2, -3, 1.5), Eigen::Vector3d(3, 3, 1.501)}};
    look();
  }
  void look() {
    frame_.depth =
        testing_scene::render(scene_, calibration_.depth, T_colour_depth_time_ * calibration_.T_colour_depth);
  }
  /// At a point of the scene, `size` pixels of the colour image.
  Feature feature(const Eigen::Vector3d& point, float size) const {
    Feature f;
    f.kind = MeasurementKind::point;
    f.point = point.cast<float>();
    f.size = size;
    return f;
  }
  bool kept(const Feature& feature, double largest_step = step) const {
    FeatureFrame features;
    features.features = {feature};
    const int left_out =
        leave_out_straddling(frame_, calibration_, T_colour_depth_time_, {largest_step, 0}, features);
    EXPECT_EQ(left_out, features.features.empty() ? 1 : 0);
    return !features.features.empty();
  }
  /// m on the board, `pixels` of the colour image beside its edge at x = 0.2.
  Eigen::Vector3d beside_edge(double pixels, double y) const {
    return {0.2 + pixels * 1.5 / calibration_.colour.fx, y, 1.5};
  }

  testing_scene::Scene scene_;
  RgbdCalibration calibration_ = testing_scene::tof_head();
  Eigen::Isometry3d T_colour_depth_time_;
  RgbdFrame frame_;
};

// Its filters reach 1.5 radii far; a depth pixel is 2.8 of colour's.
TEST_F(FeatureSupport, StraddlesWhereItsFiltersReachOverAnEdgeOfDepth) {
  for (const double y : {-0.3, 0.0, 0.25})
    for (const float size : {16.F, 30.F, 60.F}) {
      SCOPED_TRACE(size);
      EXPECT_FALSE(kept(feature(beside_edge(0.3 * static_cast<double>(size), y), size)));
      EXPECT_FALSE(kept(feature(beside_edge(0.75 * static_cast<double>(size) - 3, y), size)));
      EXPECT_TRUE(kept(feature(beside_edge(0.75 * static_cast<double>(size) + 4, y), size)));
    }
}

TEST_F(FeatureSupport, OfOneSurfaceHoweverItSlants) {
  for (const double tilt : {0.0, 0.7, -1.1}) {
    scene_.boxes.clear();
    scene_.planes = {{{std::sin(tilt), 0, std::cos(tilt)}, 2 * std::cos(tilt)}};
    look();
    EXPECT_TRUE(kept(feature({0, 0, 2}, 40)));
  }
}

TEST_F(FeatureSupport, OfARoomsCornerIsOneOfTwoSurfaces) {
  scene_.boxes.clear();
  scene_.planes = {{Eigen::Vector3d(1, 0, 1).normalized(), 2.5 / std::sqrt(2)},
                   {Eigen::Vector3d(-1, 0, 1).normalized(), 2.5 / std::sqrt(2)}};
  look();
  EXPECT_TRUE(kept(feature({0, 0, 2.5}, 30)));
}

TEST_F(FeatureSupport, SaysNothingWhereThereIsNoDepth) {
  const Feature straddling = feature(beside_edge(4, 0), 30);
  EXPECT_FALSE(kept(straddling));
  EXPECT_TRUE(kept(straddling, 1)) << "a larger step is allowed";
  Feature bearing = straddling;
  bearing.kind = MeasurementKind::bearing;
  EXPECT_TRUE(kept(bearing));
  frame_.depth.setTo(0);
  EXPECT_TRUE(kept(straddling));
  frame_.depth = cv::Mat();
  EXPECT_TRUE(kept(straddling));
}

TEST_F(FeatureSupport, WhereLittleElseIsSeenTheLargestStepsGoFirst) {
  scene_.boxes.emplace_back(Eigen::Vector3d(-3, -3, 1.7), Eigen::Vector3d(-0.3, 3, 1.701));  // a smaller step
  look();
  FeatureFrame features;
  const Eigen::Vector3d on_wall(0, 0, 2), at_small_step(-0.31, 0, 1.7);
  features.features = {feature(beside_edge(4, 0), 30), feature(on_wall, 20), feature(at_small_step, 30),
                       feature(beside_edge(4, 0.1), 30), feature(on_wall, 20)};
  const auto left = [&](int least) {
    FeatureFrame all = features;
    const int out = leave_out_straddling(frame_, calibration_, T_colour_depth_time_, {step, least}, all);
    EXPECT_EQ(all.features.size() + static_cast<std::size_t>(out), 5U);
    return all.features;
  };
  EXPECT_EQ(left(5).size(), 5U);
  EXPECT_EQ(left(1).size(), 2U);
  const auto three = left(3);
  ASSERT_EQ(three.size(), 3U);
  EXPECT_EQ(three[0].point, on_wall.cast<float>());
  EXPECT_EQ(three[1].point, at_small_step.cast<float>()) << "in the order in which they were";
}

}  // namespace
}  // namespace lcmslam

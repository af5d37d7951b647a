// Registration of the depth image into the colour camera, against exact scenes.

#include <gtest/gtest.h>

#include <lcmslam/imaging/thinned_depth.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include "tests/support/analytic_scene.hpp"
#include "tests/support/same_bits.hpp"
#include "tests/support/thinned_points.hpp"

namespace lcmslam {
namespace {

using namespace testing_scene;

// A wall 3 m in front of the camera, a little slanted.
Scene wall() {
  Scene scene;
  scene.planes.push_back({Eigen::Vector3d(0.2, -0.1, 1).normalized(), 3.0});
  return scene;
}

RgbdFrame frame_of(const cv::Mat& depth) {
  RgbdFrame frame;
  frame.depth = depth;
  return frame;
}

TEST(Registration, PointsLieOnTheWallAndUnderTheirPixels) {
  const RgbdCalibration head = tof_head();
  const Scene scene = wall();
  const auto registered = register_depth(frame_of(render(scene, head.depth, head.T_colour_depth)), head);
  ASSERT_EQ(registered.points.size(), cv::Size(176, 144));
  EXPECT_FALSE(registered.aligned);
  int coloured = 0;
  for (int v = 0; v < 144; ++v) {
    for (int u = 0; u < 176; ++u) {
      const auto& p = registered.points.at<cv::Vec3f>(v, u);
      ASSERT_TRUE(is_valid(p));
      ASSERT_NEAR(scene.planes[0].normal.dot(to_eigen(p)), scene.planes[0].offset, 6e-4);  // 1 mm steps
      const auto& pixel = registered.pixels.at<cv::Vec2f>(v, u);
      const auto expected = head.colour.project(to_eigen(p));
      ASSERT_EQ(!std::isnan(pixel[0]), expected && head.colour.contains(*expected)) << u << " " << v;
      if (std::isnan(pixel[0])) continue;
      ++coloured;
      ASSERT_NEAR(pixel[0], expected->x(), 1e-3);
      ASSERT_NEAR(pixel[1], expected->y(), 1e-3);
    }
  }
  EXPECT_GT(coloured, 176 * 144 * 9 / 10);
}

TEST(Registration, RegisteredDepthKeepsItsPixelsAndRemovesTheLens) {
  const RgbdCalibration head = registered_head();
  const Scene scene = wall();
  const auto registered =
      register_depth(frame_of(render(scene, head.depth, Eigen::Isometry3d::Identity())), head);
  EXPECT_TRUE(registered.aligned);
  for (int v = 0; v < 480; v += 7) {
    for (int u = 0; u < 640; u += 7) {
      ASSERT_EQ(registered.pixels.at<cv::Vec2f>(v, u),
                cv::Vec2f(static_cast<float>(u), static_cast<float>(v)));
      const Eigen::Vector3d p = to_eigen(registered.points.at<cv::Vec3f>(v, u));
      ASSERT_LT((p / p.z() - head.colour.ray({u, v})).norm(), 1e-5);
      ASSERT_NEAR(scene.planes[0].normal.dot(p), scene.planes[0].offset, 6e-4);
    }
  }
}

// The head moved between the two stamps: compensated, the points stand where they are at the colour
// image's time. True for the ToF head and for a registered depth image with its own stamp.
TEST(Registration, RegisteredDepthHasTheColourCamerasLensWhateverTheDepthCamerasIs) {
  const RgbdCalibration head = registered_head();
  RgbdCalibration other = head;
  other.depth.fx *= 1.3;
  other.depth.cy += 9;
  other.depth.distortion.clear();
  const cv::Mat depth = render(wall(), head.colour, Eigen::Isometry3d::Identity());
  const cv::Mat right = register_depth(frame_of(depth), head).points,
                same = register_depth(frame_of(depth), other).points;
  for (int v = 0; v < 480; v += 7)
    for (int u = 0; u < 640; u += 7) ASSERT_EQ(right.at<cv::Vec3f>(v, u), same.at<cv::Vec3f>(v, u));
}

TEST(Registration, MotionBetweenTheStampsIsCompensated) {
  Eigen::Isometry3d T_now_before = Eigen::Isometry3d::Identity();  // colour camera: then -> now
  T_now_before.translation() << 0.02, -0.01, 0.03;
  T_now_before.linear() = Eigen::AngleAxisd(0.03, Eigen::Vector3d(0.2, 1, -0.1).normalized()).matrix();
  const Scene scene = wall();
  for (const RgbdCalibration& head : {tof_head(), registered_head()}) {
    const cv::Mat depth = render(scene, head.depth, T_now_before * head.T_colour_depth);
    const auto still = register_depth(frame_of(depth), head);
    const auto moved = register_depth(frame_of(depth), head, T_now_before);
    EXPECT_FALSE(moved.aligned);
    double error_still = 0;
    for (int v = 0; v < depth.rows; v += 5) {
      for (int u = 0; u < depth.cols; u += 5) {
        const auto& n = scene.planes[0].normal;
        const Eigen::Vector3d p = to_eigen(moved.points.at<cv::Vec3f>(v, u));
        ASSERT_NEAR(n.dot(p), scene.planes[0].offset, 6e-4);
        error_still = std::max(error_still, std::abs(n.dot(to_eigen(still.points.at<cv::Vec3f>(v, u))) -
                                                     scene.planes[0].offset));
        const auto& pixel = moved.pixels.at<cv::Vec2f>(v, u);
        const auto expected = head.colour.project(p);
        if (expected && head.colour.contains(*expected)) {
          ASSERT_NEAR(pixel[0], expected->x(), 2e-3);
          ASSERT_NEAR(pixel[1], expected->y(), 2e-3);
        } else {
          ASSERT_TRUE(std::isnan(pixel[0]));
        }
      }
    }
    EXPECT_GT(error_still, 0.02);
  }
}

// A near box hides part of the wall from the colour camera, not from the depth camera 25 cm beside it.
// The truth for each point: does the segment from the colour camera to it meet the box? Points within
// 1.5 depth pixels of the box's silhouette may be judged either way.
struct OcclusionCase {
  const char* name;
  bool tof;
  int step;
};
class OcclusionTest : public testing::TestWithParam<OcclusionCase> {};

TEST_P(OcclusionTest, WhatTheBoxHidesHasNoPixel) {
  const auto [name, tof, step] = GetParam();
  RgbdCalibration head = tof ? tof_head() : registered_head();
  if (!tof) {  // a depth camera as fine as the colour camera, at its own place
    head.depth_registered = false;
    head.depth.distortion.clear();
  }
  head.T_colour_depth.translation() << 0.25, 0.02, 0;
  Scene scene = wall();
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-0.1, -0.2, 1.0), Eigen::Vector3d(0.25, 0.25, 1.4));
  scene.boxes.push_back(box);
  const auto registered = DepthRegistration(head)(frame_of(render(scene, head.depth, head.T_colour_depth)),
                                                  Eigen::Isometry3d::Identity(), step);

  const double margin = 1.5 * step * registered.pitch;  // rad
  const auto meets_box = [&](const Eigen::Vector3d& point, double dx, double dy) {
    const Eigen::Vector3d direction = point / point.z() + Eigen::Vector3d(dx, dy, 0);
    Scene only_box;
    only_box.boxes.push_back(box);
    return only_box.hit(Eigen::Vector3d::Zero(), direction) < point.z() - 0.05;
  };
  int hidden = 0;
  int seen = 0;
  int wrong_hidden = 0;
  int wrong_seen = 0;
  for (int v = 0; v < registered.points.rows; v += step) {
    for (int u = 0; u < registered.points.cols; u += step) {
      const Eigen::Vector3d p = to_eigen(registered.points.at<cv::Vec3f>(v, u));
      const auto expected = head.colour.project(p);
      if (!expected || !head.colour.contains(*expected)) continue;
      int votes = 0;
      for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j) votes += meets_box(p, i * margin, j * margin) ? 1 : 0;
      if (votes != 0 && votes != 9) continue;
      const bool has_pixel = !std::isnan(registered.pixels.at<cv::Vec2f>(v, u)[0]);
      (votes == 9 ? hidden : seen) += 1;
      wrong_seen += votes == 9 && has_pixel ? 1 : 0;
      wrong_hidden += votes == 0 && !has_pixel ? 1 : 0;
    }
  }
  EXPECT_GT(hidden, tof ? 200 : 2000 / (step * step));
  EXPECT_GT(seen, tof ? 10000 : 100000 / (step * step));
  EXPECT_EQ(wrong_seen, 0) << "of " << hidden;
  EXPECT_EQ(wrong_hidden, 0) << "of " << seen;
}

INSTANTIATE_TEST_SUITE_P(Depth, OcclusionTest,
                         testing::Values(OcclusionCase{"ToF", true, 1}, OcclusionCase{"Fine", false, 1},
                                         OcclusionCase{"Thinned", false, 4}),
                         [](const auto& test) { return std::string(test.param.name); });

// The ground under an inclined head, seen at a grazing angle, recedes by decimetres from one ToF pixel to
// the next: it must not hide itself, noise or not.
TEST(Registration, AGrazingGroundDoesNotHideItself) {
  const RgbdCalibration head = tof_head();
  Scene ground;
  ground.planes.push_back({Eigen::Vector3d(0, std::cos(0.2), std::sin(0.2)), 1.3});
  Random random(4);
  for (bool noisy : {false, true}) {
    const auto registered = register_depth(frame_of(render(ground, head.depth, head.T_colour_depth,
                                                           noisy ? &head.depth_noise : nullptr, &random)),
                                           head);
    int inside = 0;
    int hidden = 0;
    for (int v = 0; v < 144; ++v) {
      for (int u = 0; u < 176; ++u) {
        const auto& p = registered.points.at<cv::Vec3f>(v, u);
        if (!is_valid(p)) continue;
        const auto pixel = head.colour.project(to_eigen(p));
        if (!pixel || !head.colour.contains(*pixel)) continue;
        ++inside;
        hidden += std::isnan(registered.pixels.at<cv::Vec2f>(v, u)[0]) ? 1 : 0;
      }
    }
    EXPECT_GT(inside, 5000);
    EXPECT_LE(hidden, inside / 500) << (noisy ? "with noise" : "exact");
  }
}

TEST(Registration, DepthsOutsideTheRangeAreInvalid) {
  RgbdCalibration head = registered_head();
  head.depth_min = 0.5;
  head.depth_max = 4;
  cv::Mat depth(480, 640, CV_16UC1, cv::Scalar(2000));
  depth.at<std::uint16_t>(0, 0) = 0;
  depth.at<std::uint16_t>(0, 1) = 65535;
  depth.at<std::uint16_t>(0, 2) = 499;
  depth.at<std::uint16_t>(0, 3) = 500;
  depth.at<std::uint16_t>(0, 4) = 4000;
  depth.at<std::uint16_t>(0, 5) = 4001;
  const auto registered = register_depth(frame_of(depth), head);
  const bool expected[] = {false, false, false, true, true, false, true};
  for (int u = 0; u < 7; ++u) {
    EXPECT_EQ(is_valid(registered.points.at<cv::Vec3f>(0, u)), expected[u]) << u;
    EXPECT_EQ(!std::isnan(registered.pixels.at<cv::Vec2f>(0, u)[0]), expected[u]) << u;
    EXPECT_EQ(!std::isnan(registered.sigma.at<float>(0, u)), expected[u]) << u;
  }
}

TEST(Registration, SigmaFollowsTheNoiseModelAndTheAmplitude) {
  RgbdCalibration head = tof_head();
  head.depth_noise = {0.001, 0, 0, 0.001};
  RgbdFrame frame = frame_of(cv::Mat(144, 176, CV_16UC1, cv::Scalar(2000)));
  EXPECT_NEAR(register_depth(frame, head).sigma.at<float>(3, 4), 0.005, 1e-7);  // no amplitude: full
  frame.amplitude = cv::Mat(144, 176, CV_8UC1, cv::Scalar(51));
  EXPECT_NEAR(register_depth(frame, head).sigma.at<float>(3, 4), 0.001 + 0.004 * std::sqrt(5), 1e-7);
}

TEST(Registration, WrongInputIsRefused) {
  const RgbdCalibration head = tof_head();
  EXPECT_THROW(register_depth(frame_of(cv::Mat(144, 175, CV_16UC1)), head), std::invalid_argument);
  EXPECT_THROW(register_depth(frame_of(cv::Mat(144, 176, CV_8UC1)), head), std::invalid_argument);
  RgbdFrame frame = frame_of(cv::Mat(144, 176, CV_16UC1, cv::Scalar(1000)));
  frame.amplitude = cv::Mat(144, 175, CV_8UC1);
  EXPECT_THROW(register_depth(frame, head), std::invalid_argument);
  frame.amplitude.release();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().x() = std::nan("");
  EXPECT_THROW(register_depth(frame, head, T), std::invalid_argument);
  RgbdCalibration wrong = head;
  wrong.depth.fx = 0;
  EXPECT_THROW(DepthRegistration{wrong}, std::invalid_argument);
}

TEST(Registration, AFrameWithoutDepthHasNoPoints) {
  const auto registered = register_depth(RgbdFrame{}, tof_head());
  ASSERT_EQ(registered.points.size(), cv::Size(176, 144));
  EXPECT_FALSE(is_valid(registered.points.at<cv::Vec3f>(70, 80)));
  RgbdFrame frame;
  frame.colour = cv::Mat(480, 640, CV_8UC3, cv::Scalar(0));
  EXPECT_EQ(make_cloud(frame, registered, 1, true).size(), 0u);
  EXPECT_TRUE(std::isnan(depth_at_pixels(registered, tof_head(), {{320, 240}})[0].point.z()));
}

TEST(Registration, AThinnedImageIsThatOfAllItsPoints) {
  for (const RgbdCalibration& head : {tof_head(), registered_head()}) {
    const CameraModel& camera = head.depth_registered ? head.colour : head.depth;
    RgbdFrame frame = frame_of(render(wall(), camera, Eigen::Isometry3d::Identity()));
    for (int v = 0; v < frame.depth.rows; ++v)
      for (int u = 0; u < frame.depth.cols; ++u)
        if ((u * v) % 11 == 0) frame.depth.at<std::uint16_t>(v, u) = 0;
    if (!head.depth_registered) frame.amplitude = cv::Mat(frame.depth.size(), CV_8UC1, cv::Scalar(40));
    const DepthRegistration registration(head);
    const RegisteredDepth whole = registration.unproject(frame);
    for (const int step : {1, 3, 5}) {
      const ThinnedDepth thin = DepthPoints(registration.calibration()).thinned(frame, step),
                         expected = testing_scene::thinned(whole, step);
      EXPECT_TRUE(same_bits(thin.points, expected.points)) << step;
      EXPECT_TRUE(same_bits(thin.sigma, expected.sigma)) << step;
      EXPECT_TRUE(same_bits(thin.normals, expected.normals)) << step;
      EXPECT_EQ(thin.rows, camera.height);
      EXPECT_EQ(thin.pitch, whole.pitch);
    }
  }
}

}  // namespace
}  // namespace lcmslam

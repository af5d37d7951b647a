// A texture on a steep wall, seen from far and near by a lens: where its middle lies is known.

#include <lcmslam/calibration/self/aligned_sightings.hpp>

#include <gtest/gtest.h>
#include <cmath>

namespace lcmslam {
namespace {

RgbdCalibration one_lens() {
  RgbdCalibration c;
  c.colour.width = 320, c.colour.height = 240;
  c.colour.fx = c.colour.fy = 280, c.colour.cx = 158, c.colour.cy = 121;
  c.colour.distortion = {-0.12, 0.05, 0.0005, -0.0003, 0};
  c.depth = c.colour;
  c.depth_registered = true;
  return c;
}

/// Of the wall: n p = 1, in the first keyframe's camera, which is the world.
const Eigen::Vector3d steep_wall(0.9, 0.25, 0.55);

Eigen::Vector3d on_steep_wall(const Eigen::Vector3d& origin, const Eigen::Vector3d& along) {
  return origin + (1 - steep_wall.dot(origin)) / steep_wall.dot(along) * along;
}

double grey_of(const Eigen::Vector3d& p) {
  return 120 + 40 * std::sin(75 * p.z() + 31 * p.y()) + 30 * std::cos(95 * p.y() - 20 * p.z()) +
         25 * std::sin(43 * p.z() - 60 * p.y() + 1);
}

cv::Mat seen_from(const Eigen::Isometry3d& T_world_camera, const CameraModel& camera) {
  cv::Mat image(camera.height, camera.width, CV_8UC1);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(
          grey_of(on_steep_wall(T_world_camera.translation(), T_world_camera.linear() * camera.ray({u, v}))));
  return image;
}

struct TwoViews {
  RgbdCalibration calibration = one_lens();
  std::vector<ObservedKeyframe> keyframes{2};
  SightedLandmark landmark;
  Eigen::Vector2d there;  // of the landmark in the second view

  explicit TwoViews(const Eigen::Vector2d& at) {
    const CameraModel& camera = calibration.colour;
    keyframes[1].T_world_camera.translation() << 0.06, -0.02, 0.22;
    for (ObservedKeyframe& keyframe : keyframes) keyframe.grey = seen_from(keyframe.T_world_camera, camera);
    keyframes[0].inverse_depth.create(camera.height, camera.width, CV_32FC1);
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u)
        keyframes[0].inverse_depth.at<float>(v, u) =
            static_cast<float>(std::max(0.0, steep_wall.dot(camera.ray({u, v}))));
    landmark.point = on_steep_wall(Eigen::Vector3d::Zero(), camera.ray(at));
    there = *camera.project(keyframes[1].T_world_camera.inverse() * landmark.point);
    // The middle one is the texture's; a detector errs by a pixel.
    landmark.sightings = {{1, there + Eigen::Vector2d(0.7, -0.5), 1}, {0, at, 1}};
  }
};

TEST(AlignedSightings, ASteepWallBendsTexturesAndTheirMiddleStays) {
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(190, 130), Eigen::Vector2d(215, 95), Eigen::Vector2d(200, 150)}) {
    TwoViews views(at);
    align_sightings(views.landmark, views.keyframes, views.calibration);
    ASSERT_EQ(views.landmark.sightings.size(), 2U) << at.transpose();
    EXPECT_LT((views.landmark.sightings[0].pixel - views.there).norm(), 0.03) << at.transpose();
  }
}

TEST(AlignedSightings, WhatIsAtAnEdgeOfDepthLeaves) {
  const Eigen::Vector2d at(190, 130);
  TwoViews views(at);
  cv::Mat& inverse = views.keyframes[0].inverse_depth;
  inverse.colRange(191, inverse.cols) *= 0.5;
  align_sightings(views.landmark, views.keyframes, views.calibration);
  EXPECT_TRUE(views.landmark.sightings.empty());

  TwoViews blind(at);  // where depth says nothing, textures do
  blind.keyframes[0].inverse_depth.setTo(0);
  align_sightings(blind.landmark, blind.keyframes, blind.calibration);
  EXPECT_EQ(blind.landmark.sightings.size(), 2U);
}

}  // namespace
}  // namespace lcmslam

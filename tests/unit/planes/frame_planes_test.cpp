#include <gtest/gtest.h>

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/planes/frame_planes.hpp>
#include "tests/unit/planes/table_room.hpp"

namespace lcmslam {
namespace {

constexpr double degree = 0.0174533;

/// The plane of the frame that is this plane of the room; null when none is within 1 degree and 1 cm.
const FramePlane* find(const FramePlanes& found, const Eigen::Isometry3d& T, const Eigen::Vector3d& normal,
                       double offset) {
  for (const FramePlane& plane : found.planes) {
    const Eigen::Vector3d seen = T.linear() * plane.fit.plane.normal;
    const Eigen::Vector3d centre = T * plane.fit.centre;
    if (std::acos(std::min(1.0, seen.dot(normal))) < degree && std::abs(normal.dot(centre) + offset) < 0.01)
      return &plane;
  }
  return nullptr;
}

TEST(FramePlanes, FloorWallsAndTableTopAreFoundWithinADegree) {
  FramePlaneFinder finder(testing::room_camera());
  for (const testing::RoomLook& look : testing::room_looks()) {
    const FramePlanes found = finder(look.depth);
    EXPECT_NE(find(found, look.T_map_depth, {0, 0, 1}, 0), nullptr);
    EXPECT_NE(find(found, look.T_map_depth, {0, 0, 1}, -testing::table_height), nullptr);
    const bool sees_wall = look.T_map_depth.linear()(0, 2) > 0.5;
    EXPECT_EQ(find(found, look.T_map_depth, {-1, 0, 0}, 3) != nullptr, sees_wall);
    EXPECT_LT(found.planes.size(), 9u);
  }
}

TEST(FramePlanes, PixelsAreLabelledByThePlaneTheyLieIn) {
  FramePlaneFinder finder(testing::room_camera());
  const testing::RoomLook& look = testing::room_looks()[0];
  const FramePlanes found = finder(look.depth);
  const FramePlane* table = find(found, look.T_map_depth, {0, 0, 1}, -testing::table_height);
  ASSERT_NE(table, nullptr);
  const auto number = static_cast<int>(table - found.planes.data()) + 1;
  int on_table = 0, right = 0, wrong = 0;
  for (int v = 0; v < look.depth.rows; ++v)
    for (int u = 0; u < look.depth.cols; ++u) {
      const Eigen::Vector3d point =
          look.T_map_depth * finder.cells()
                                 .point(v, u, 0.001f * static_cast<float>(look.depth.at<std::uint16_t>(v, u)))
                                 .cast<double>();
      const bool is_table =
          std::abs(point.z() - testing::table_height) < 0.004 && point.x() < 2.02 && point.x() > 1.18;
      const bool far_off = std::abs(point.z() - testing::table_height) > 0.03;
      const bool labelled = found.labels.at<std::uint8_t>(v, u) == number;
      on_table += is_table;
      right += is_table && labelled;
      wrong += far_off && labelled;
    }
  EXPECT_GT(right, 0.95 * on_table);
  EXPECT_LT(wrong, 0.01 * on_table);
}

TEST(FramePlanes, PiecesAreJoinedBeforeSmallOnesAreLeftOut) {
  // A board of 2 m x 0.15 m, 2 m away, behind posts: pieces of two by two cells each.
  testing_scene::Scene scene{{}, {{Eigen::Vector3d(-1, -0.075, 2), Eigen::Vector3d(1, 0.075, 2.1)}}};
  for (int i = -6; i <= 6; ++i)
    scene.boxes.emplace_back(Eigen::Vector3d(0.12 * i - 0.02, -1, 1),
                             Eigen::Vector3d(0.12 * i + 0.02, 1, 1.02));
  const RgbdCalibration camera = testing::room_camera();
  FramePlaneFinder finder(camera);
  const auto boards = [&] {
    int count = 0;
    for (const FramePlane& plane :
         finder(testing_scene::render(scene, camera.colour, Eigen::Isometry3d::Identity())).planes)
      count += std::abs(plane.fit.centre.z() - 2) < 0.01 ? 1 : 0;
    return count;
  };
  EXPECT_EQ(boards(), 1);
  scene.boxes[0] = {Eigen::Vector3d(-0.1, -0.075, 2), Eigen::Vector3d(0.1, 0.075, 2.1)};
  EXPECT_EQ(boards(), 0) << "one piece alone is too small";
}

/// A post of 0.15 m x 0.1 m before a wall. Its edges cross the image at a slant, so that cells see all parts
/// of both of its sides.
const testing_scene::Scene post{{{{0, 0, 1}, 4}},
                                {{Eigen::Vector3d(-0.07, -0.5, 1.5), Eigen::Vector3d(0.03, 0.5, 1.65)}}};
const Eigen::Isometry3d T_before_post =
    Eigen::Translation3d(0.7, 0, 0) * Eigen::AngleAxisd(-0.45, Eigen::Vector3d::UnitY()) *
    Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitZ()) * Eigen::Isometry3d::Identity();

TEST(FramePlanes, BothSidesOfAPostAreFoundWithinADegree) {
  const RgbdCalibration camera = testing::room_camera();
  FramePlaneFinder finder(camera);
  Random random(2);
  const FramePlanes found =
      finder(testing_scene::render(post, camera.colour, T_before_post, &camera.depth_noise, &random));
  EXPECT_NE(find(found, T_before_post, {0, 0, -1}, 1.5), nullptr);
  EXPECT_NE(find(found, T_before_post, {1, 0, 0}, -0.03), nullptr);
}

TEST(FramePlanes, PixelsAtAnEdgeAreTheirOwnSides) {
  const RgbdCalibration camera = testing::room_camera();
  FramePlaneFinder finder(camera);
  const cv::Mat depth = testing_scene::render(post, camera.colour, T_before_post);
  const FramePlanes found = finder(depth);
  ASSERT_GE(found.planes.size(), 3u);
  int others = 0, far_off = 0;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const int label = found.labels.at<std::uint8_t>(v, u);
      if (label == 0) continue;
      const Eigen::Vector3d point =
          finder.cells()
              .point(v, u, 0.001f * static_cast<float>(depth.at<std::uint16_t>(v, u)))
              .cast<double>();
      const double off =
          std::abs(found.planes[static_cast<std::size_t>(label) - 1].fit.plane.distance(point));
      for (const FramePlane& plane : found.planes)
        others += std::abs(plane.fit.plane.distance(point)) < off - 0.001 ? 1 : 0;
      far_off += off > 3.1 * finder.cells().sigma(point.z()) ? 1 : 0;
    }
  // Not none: planes are fitted anew to the pixels that chose them.
  EXPECT_LT(others, 60);
  EXPECT_LT(far_off, 6);
}

/// Degrees by which all that images show of a plane of the post's scene is tilted: by a time-of-flight camera
/// whose sides of the post are 8 and 11 pixels wide.
double tilt_over_images(const Eigen::Vector3d& normal, double offset) {
  RgbdCalibration camera;
  camera.colour = {176, 144, 200, 200, 87.5, 71.5, {}};
  camera.depth_registered = true;
  camera.depth_noise = {0.0042, 0, 0, 0.001};
  const DepthNoise noise{0.002, 0.001, 0, 0};
  const cv::Mat bright(144, 176, CV_8UC1, cv::Scalar(200));
  FramePlaneFinder finder(camera);
  DepthFilter filter(camera);
  Random random(4);
  PlaneMoments all;
  for (int i = 0; i < 30; ++i) {
    cv::Mat depth = testing_scene::render(post, camera.colour, T_before_post, &noise, &random);
    filter(depth, bright);
    for (const FramePlane& plane : finder(depth).planes) {
      const Eigen::Vector3d centre = T_before_post * plane.fit.centre;
      if ((T_before_post.linear() * plane.fit.plane.normal).dot(normal) > 0.9 &&
          std::abs(normal.dot(centre) + offset) < 0.02)
        all.add(plane.moments);
    }
  }
  const Eigen::Vector3d seen = T_before_post.linear() * all.fit(Eigen::Vector3d::Zero()).plane.normal;
  return std::acos(std::min(1.0, seen.dot(normal))) / degree;
}

TEST(FramePlanes, WhatIsFewPixelsWideIsNotTiltedByItsNeighbours) {
  EXPECT_LT(tilt_over_images({0, 0, -1}, 1.5), 0.5);
  EXPECT_LT(tilt_over_images({1, 0, 0}, -0.03), 0.5);
}

TEST(FramePlanes, WhatIsTooUncertainIsNoPlane) {
  const RgbdCalibration camera = testing::room_camera();
  FramePlaneFinder finder(camera);
  const auto planes = [&](double distance) {
    const testing_scene::Scene wall{{{{0, 0, 1}, distance}}, {}};
    return finder(testing_scene::render(wall, camera.colour, Eigen::Isometry3d::Identity())).planes.size();
  };
  EXPECT_EQ(planes(5.2), 1u);  // sigma 29 mm
  EXPECT_EQ(planes(5.5), 0u);  // 32 mm
}

TEST(FramePlanes, ABallIsNoPlane) {
  const RgbdCalibration camera = testing::room_camera();
  cv::Mat depth(240, 320, CV_16UC1);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u) {
      // A ball of 0.08 m around (0, 0, 0.5).
      const Eigen::Vector3d ray = camera.colour.ray({u, v});
      const double b = 0.5 * ray.z(), discriminant = b * b - ray.squaredNorm() * (0.25 - 0.0064);
      depth.at<std::uint16_t>(v, u) =
          discriminant < 0 ? std::uint16_t{0}
                           : static_cast<std::uint16_t>(
                                 std::lround(1000 * (b - std::sqrt(discriminant)) / ray.squaredNorm()));
    }
  FramePlaneFinder finder(camera);
  EXPECT_TRUE(finder(depth).planes.empty());
}

TEST(FramePlanes, AnImageOfAnotherSizeIsRefused) {
  FramePlaneFinder finder(testing::room_camera());
  EXPECT_THROW(finder(cv::Mat(10, 10, CV_16UC1)), std::invalid_argument);
  FramePlaneSettings settings;
  settings.cells_across = 0;
  EXPECT_THROW(FramePlaneFinder(testing::room_camera(), settings), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

// Maps that more than one camera has looked at.

#include <gtest/gtest.h>

#include "tests/unit/live_map/seen_walls.hpp"

namespace lcmslam {
namespace {

/// With fewer pixels, farther apart.
LiveMap::Calibration wide_camera() {
  RgbdCalibration calibration;
  calibration.colour = calibration.depth = CameraModel{80, 60, 40, 40, 39.5, 29.5, {}};
  calibration.depth_registered = true;
  return std::make_shared<RgbdCalibration>(calibration);
}

RgbdFrame wide_wall(double distance) {
  RgbdFrame frame;
  frame.depth = cv::Mat(60, 80, CV_16UC1, cv::Scalar(1000 * distance));
  frame.colour = cv::Mat(60, 80, CV_8UC3, cv::Scalar(50, 100, 150));
  return frame;
}

/// Greatest distance from the way that the mesh has near a wall, m.
double half_width(const Mesh& mesh, double x) {
  double most = 0;
  for (const Eigen::Vector3f& v : mesh.vertices)
    if (std::abs(static_cast<double>(v.x()) - x) < 0.1)
      most = std::max(most, std::abs(static_cast<double>(v.y())));
  return most;
}

TEST(LiveMapCameras, EachKeyframeIsReadByItsOwn) {
  for (const bool background : {false, true}) {
    LiveMapSettings settings = waiting();
    settings.background = background;
    settings.planes.min_looks = 1;
    const auto camera = std::make_shared<RgbdCalibration>(some_camera());
    LiveMap map(camera, settings);
    map.keep(1, wall(2), at(0));
    EXPECT_THROW(map.keep(2, wide_wall(2), at(5)), std::invalid_argument);
    map.look_through(wide_camera());
    EXPECT_THROW(map.keep(2, wall(2), at(5)), std::invalid_argument);
    map.keep(2, wide_wall(2), at(5));
    map.look_through(camera);
    map.keep(3, wall(2), at(10));
    map.follow({{1, at(0.4).T_map_camera}, {2, at(5.4).T_map_camera}, {3, at(10.4).T_map_camera}});
    map.settle();  // all is made anew
    const Mesh mesh = map.settled_mesh();
    // (pixels from the middle) x distance / focal length
    EXPECT_NEAR(half_width(mesh, 2.4), 1.14, 0.06);
    EXPECT_NEAR(half_width(mesh, 7.4), 1.98, 0.1);
    EXPECT_NEAR(half_width(mesh, 12.4), 1.14, 0.06);
    for (const double x : {2.42, 7.42, 12.42}) EXPECT_EQ(state(map, x), CellState::occupied) << x;
    const auto wide = [&](const OccupancyGrid& occupied) {
      return occupied.state(Eigen::Vector3f(7.42F, 1.8F, 1.0F));
    };
    EXPECT_EQ(map.space().ask_occupied(wide), CellState::occupied);
    const auto planes = map.planes();
    ASSERT_EQ(planes.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(planes[i].fit.centre.x(), 2.4 + 5.0 * static_cast<double>(i), 0.01);
    EXPECT_NEAR(planes[1].area, 4 * 1.98 * 1.48, 1.5);
    EXPECT_NEAR(planes[2].area, 4 * 1.14 * 0.85, 0.6);
    EXPECT_GT(map.cloud(0.05).size(), 2 * 40 * 30U);
  }
}

}  // namespace
}  // namespace lcmslam

// Features placed by depth that was moved.

#include <lcmslam/rgbd/feature_depth.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

/// A wall 2 m ahead with a board in front of its right half, as a depth camera of 160 x 120 sees it.
struct Wall {
  CameraModel camera;
  RegisteredDepth depth;

  Wall() {
    camera.width = 160;
    camera.height = 120;
    camera.fx = camera.fy = 130;
    camera.cx = 79.5;
    camera.cy = 59.5;
    depth.points.create(120, 160, CV_32FC3);
    depth.sigma = cv::Mat(120, 160, CV_32FC1, cv::Scalar(0.005));
    for (int v = 0; v < 120; ++v)
      for (int u = 0; u < 160; ++u) {
        const double z = u < 100 ? 2.0 : 1.0;
        const Eigen::Vector3d p = z * camera.ray({u, v});
        depth.points.at<cv::Vec3f>(v, u) = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                                            static_cast<float>(p.z())};
      }
  }

  FeatureFrame features(std::vector<float> columns) const {
    FeatureFrame f;
    f.fx = f.fy = 130;
    f.cx = 79.5;
    f.cy = 59.5;
    for (const float x : columns) {
      Feature feature;
      feature.x = x;
      feature.y = 40;
      feature.kind = MeasurementKind::point;
      feature.point = {0, 0, 1.5f};
      feature.depth_sigma = 1;
      f.features.push_back(feature);
    }
    return f;
  }
};

TEST(FeatureDepth, ReadsWhereTheFeatureWas) {
  const Wall wall;
  const auto still =
      placed_by(wall.depth, wall.camera, Eigen::Isometry3d::Identity(), wall.features({50, 99.5f, 130}));
  EXPECT_NEAR(still.features[0].point.z(), 2, 1e-3);
  EXPECT_NEAR(still.features[0].point.x(), 2 * (50 - 79.5) / 130, 1e-3);
  EXPECT_FLOAT_EQ(still.features[0].depth_sigma, 0.005f);
  EXPECT_EQ(still.features[1].kind, MeasurementKind::bearing);  // on the edge
  EXPECT_TRUE(std::isnan(still.features[1].point.x()));
  EXPECT_NEAR(still.features[2].point.z(), 1, 1e-3);
  // The depth camera has turned right by 0.15 rad, about 20 pixels: the feature's place was seen 20 pixels
  // farther left.
  Eigen::Isometry3d T_depth_colour = Eigen::Isometry3d::Identity();
  T_depth_colour.linear() = so3_exp({0, -0.15, 0});
  const auto turned = placed_by(wall.depth, wall.camera, T_depth_colour, wall.features({112}));
  EXPECT_NEAR(turned.features[0].point.z(), 2, 1e-3);
}

TEST(FeatureDepth, ADepthImageSaysWhatItsPointsSay) {
  const Wall wall;
  RgbdCalibration calibration;
  calibration.colour = calibration.depth = wall.camera;
  calibration.T_colour_depth.translation() = Eigen::Vector3d(0.03, -0.02, 0.01);
  calibration.T_colour_depth.linear() = so3_exp({0.01, -0.02, 0.03});
  const DepthRegistration registration(calibration);
  RgbdFrame frame;
  frame.depth.create(120, 160, CV_16UC1);
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u)
      frame.depth.at<std::uint16_t>(v, u) =
          (u * v) % 7 == 0 ? 0 : static_cast<std::uint16_t>((u < 100 ? 2000 : 1000) + (u ^ v) % 4);
  std::vector<float> columns;
  for (float x = -1; x < 162; x += 1.7f) columns.push_back(x);
  const Eigen::Isometry3d T_depth_colour = calibration.T_colour_depth.inverse();
  Eigen::Isometry3d T_points = Eigen::Isometry3d::Identity();
  T_points.linear() = so3_exp({0, 0.01, 0});
  const FeatureFrame by_points =
      placed_by(registration.unproject(frame), wall.camera, T_depth_colour, wall.features(columns), T_points);
  const FeatureFrame by_image = placed_by(DepthPoints(registration.calibration()), frame, T_depth_colour,
                                          wall.features(columns), T_points);
  int points = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Feature &a = by_points.features[i], &b = by_image.features[i];
    ASSERT_EQ(a.kind, b.kind) << i;
    if (a.kind != MeasurementKind::point) continue;
    ++points;
    EXPECT_EQ(a.point, b.point) << i;
    EXPECT_EQ(a.depth_sigma, b.depth_sigma) << i;
  }
  EXPECT_GT(points, 50);
}

}  // namespace
}  // namespace lcmslam

#include <lcmslam/rgbd/depth_view.hpp>

#include <gtest/gtest.h>

#include <map>

#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include <lcmslam/rgbd/rolling_shutter.hpp>
#include "tests/support/thinned_points.hpp"

namespace lcmslam {
namespace {

constexpr int width = 160, height = 120;
constexpr float focal_length = 130;

/// A plane n . p = d (frame of the middle row) as a camera sees it whose rows are read one after the other.
DepthView view_of_plane(const Eigen::Vector3d& n, double d, const Vector6d& motion, int step) {
  RegisteredDepth depth;
  depth.pitch = 1 / focal_length;
  depth.points.create(height, width, CV_32FC3);
  depth.sigma = cv::Mat(height, width, CV_32FC1, cv::Scalar(0.002));
  for (int v = 0; v < height; ++v) {
    const Eigen::Isometry3d T = row_transform(v, height, motion).cast<double>();
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector3d ray((u - 79.5) / 130, (v - 59.5) / 130, 1);
      const double z = (d - n.dot(T.translation())) / n.dot(T.linear() * ray);
      depth.points.at<cv::Vec3f>(v, u) = cv::Vec3d(z * ray.x(), z * ray.y(), z);
    }
  }
  return testing_scene::thinned(depth, step);
}

// Worst distance from the plane, m, and worst angle between normals, rad.
std::pair<double, double> errors(const Cloud& cloud, const Eigen::Vector3d& n, double d) {
  double distance = 0, angle = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    distance = std::max(distance, std::abs(n.dot(cloud.points[i].cast<double>()) - d));
    angle = std::max(angle, (cloud.normals[i].cast<double>() + n).norm());
  }
  return {distance, angle};
}

TEST(DepthView, RowsReadWhileTheCameraMovesGiveThePlaneAndItsNormals) {
  Random random(11);
  for (int round = 0; round < 20; ++round) {
    SCOPED_TRACE(round);
    const Eigen::Vector3d n =
        Eigen::Vector3d(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 1).normalized();
    Vector6d motion;
    for (int i = 0; i < 3; ++i) motion[i] = random.uniform(-0.02, 0.02);
    for (int i = 3; i < 6; ++i) motion[i] = random.uniform(-0.06, 0.06);
    motion[3] += 0.06;  // pitching is what tilts normals
    const DepthView view = view_of_plane(n, 2, motion, 4);
    Vector6d pose;
    pose << 0.1, random.uniform(-0.1, 0.1), 0, random.uniform(-0.1, 0.1), 0.1, 0;
    const Eigen::Isometry3d T = se3_exp(pose);
    const Eigen::Isometry3d still = Eigen::Isometry3d::Identity();
    const auto [distance, angle] = errors(cloud_of(view, still, motion), n, 2);
    EXPECT_LT(distance, 1e-4);
    EXPECT_LT(angle, 0.01);
    const auto [sheared, tilted] = errors(cloud_of(view, still, Vector6d::Zero()), n, 2);
    EXPECT_GT(sheared, 50 * distance);
    EXPECT_GT(tilted, 3 * angle);
    // Moved in time: the plane seen from there. Rows' motion is told in the moved camera's frame.
    const Vector6d there = adjoint(T) * motion;
    const Eigen::Vector3d n_there = T.linear() * n;
    const auto [moved, turned] = errors(cloud_of(view, T, there), n_there, 2 + n_there.dot(T.translation()));
    EXPECT_LT(moved, 1e-3);
    EXPECT_LT(turned, 0.02);
  }
}

TEST(DepthView, TakesTheSamePointsAsTheColouredCloud) {
  RgbdCalibration calibration;
  calibration.depth.width = calibration.colour.width = width;
  calibration.depth.height = calibration.colour.height = height;
  calibration.depth.fx = calibration.depth.fy = calibration.colour.fx = calibration.colour.fy = 130;
  calibration.depth.cx = calibration.colour.cx = 79.5;
  calibration.depth.cy = calibration.colour.cy = 59.5;
  calibration.depth_registered = true;
  RgbdFrame frame;
  frame.depth.create(height, width, CV_16UC1);
  frame.colour = cv::Mat(height, width, CV_8UC3, cv::Scalar::all(100));
  Random random(3);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      frame.depth.at<std::uint16_t>(v, u) =
          random.below(10) == 0 ? 0 : static_cast<std::uint16_t>(1500 + 3 * u + random.below(4));
  const DepthRegistration registration(calibration);
  const ColouredCloud coloured = usable_points(make_cloud(frame, registration(frame), 3));
  const Cloud plain = usable_points(cloud_of(DepthPoints(registration.calibration()).thinned(frame, 3),
                                             Eigen::Isometry3d::Identity(), Vector6d::Zero()));
  ASSERT_GT(plain.size(), 500U);
  ASSERT_EQ(plain.size(), coloured.size());
  // Another order: each pixel's ray is its own.
  using Pixel = std::pair<float, float>;
  std::map<Pixel, std::size_t> place;
  const auto pixel = [](const Eigen::Vector3f& p) { return Pixel(p.x() / p.z(), p.y() / p.z()); };
  for (std::size_t i = 0; i < coloured.size(); ++i) place[pixel(coloured.points[i])] = i;
  ASSERT_EQ(place.size(), coloured.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const auto same = place.find(pixel(plain.points[i]));
    ASSERT_NE(same, place.end());
    EXPECT_EQ(plain.points[i], coloured.points[same->second]);
    EXPECT_EQ(plain.normals[i], coloured.normals[same->second]);
    EXPECT_EQ(plain.sigmas[i], coloured.sigmas[same->second]);
  }
}

}  // namespace
}  // namespace lcmslam

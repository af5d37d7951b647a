// Clouds, normals and the depth under colour pixels, against exact scenes.

#include <gtest/gtest.h>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include "tests/support/analytic_scene.hpp"

namespace lcmslam {
namespace {

using namespace testing_scene;

RgbdFrame frame_of(const cv::Mat& depth) {
  RgbdFrame frame;
  frame.depth = depth;
  return frame;
}

struct Case {
  const char* name;
  bool tof;
  Eigen::Vector3d normal;  // towards the camera
  double distance;         // m from the camera along the normal
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

class PlaneTest : public testing::TestWithParam<Case> {
 protected:
  PlaneTest() : head(GetParam().tof ? tof_head() : registered_head()) {
    scene.planes.push_back({GetParam().normal.normalized(), -GetParam().distance});
  }
  RgbdCalibration head;
  Scene scene;
};

TEST_P(PlaneTest, NormalsOfAnExactPlane) {
  const auto registered = register_depth(frame_of(render(scene, head.depth, head.T_colour_depth)), head);
  const cv::Mat normals = estimate_normals(registered, 3);
  ASSERT_EQ(normals.size(), cv::Size((head.depth.width + 2) / 3, (head.depth.height + 2) / 3));
  int known = 0;
  int possible = 0;
  double worst = 0;
  for (int v = 0; v < normals.rows; ++v) {
    for (int u = 0; u < normals.cols; ++u) {
      possible += is_valid(registered.points.at<cv::Vec3f>(3 * v, 3 * u)) ? 1 : 0;
      const auto& n = normals.at<cv::Vec3f>(v, u);
      if (!is_valid(n)) continue;
      ++known;
      ASSERT_NEAR(cv::norm(n), 1, 1e-5);
      worst = std::max(worst, std::acos(std::min(1.0, to_eigen(n).dot(scene.planes[0].normal))));
    }
  }
  EXPECT_GT(known, possible * 95 / 100);
  EXPECT_LT(worst, 0.15);  // depth is rounded to 1 mm
}

TEST_P(PlaneTest, NormalsOfANoisyPlane) {
  Random random(7);
  const auto registered = register_depth(
      frame_of(render(scene, head.depth, head.T_colour_depth, &head.depth_noise, &random)), head);
  const cv::Mat normals = estimate_normals(registered, 2);
  double squared = 0;
  int known = 0;
  int possible = 0;
  for (int v = 0; v < normals.rows; ++v) {
    for (int u = 0; u < normals.cols; ++u) {
      possible += is_valid(registered.points.at<cv::Vec3f>(2 * v, 2 * u)) ? 1 : 0;
      const auto& n = normals.at<cv::Vec3f>(v, u);
      if (!is_valid(n)) continue;
      ++known;
      const double angle = std::acos(std::min(1.0, to_eigen(n).dot(scene.planes[0].normal)));
      squared += angle * angle;
    }
  }
  EXPECT_GT(known, possible * 9 / 10);
  EXPECT_LT(std::sqrt(squared / known), 0.2);
}

// Interpolated depth: on the plane, on the pixel's own ray, with an honest sigma.
TEST_P(PlaneTest, DepthAtPixels) {
  Random random(8);
  const auto registered = register_depth(
      frame_of(render(scene, head.depth, head.T_colour_depth, &head.depth_noise, &random)), head);
  std::vector<cv::Point2f> pixels;
  for (int i = 0; i < 1000; ++i)
    pixels.emplace_back(static_cast<float>(random.uniform(150, 490)),
                        static_cast<float>(random.uniform(120, 360)));
  const auto depths = depth_at_pixels(registered, head, pixels);
  ASSERT_EQ(depths.size(), pixels.size());
  int found = 0;
  double chi2 = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector3d ray = head.colour.ray({pixels[i].x, pixels[i].y});
    const double truth = scene.hit(Eigen::Vector3d::Zero(), ray);
    if (std::isnan(depths[i].sigma)) continue;
    ++found;
    const Eigen::Vector3d p = depths[i].point.cast<double>();
    ASSERT_LT((p / p.z() - ray).norm(), 1e-5);
    ASSERT_GE(depths[i].sigma, 0.9 * head.depth_noise.sigma(p.z()));
    chi2 += std::pow((p.z() - truth) / depths[i].sigma, 2);
  }
  EXPECT_GT(found, 950);
  EXPECT_LT(chi2 / found, 1.0);  // averaging can only help
  EXPECT_GT(chi2 / found, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Planes, PlaneTest,
                         testing::Values(Case{"tof_facing", true, {0, 0, -1}, 2},
                                         Case{"tof_slanted", true, {0.8, 0.1, -1}, 2},
                                         Case{"tof_floor", true, {0, -1, -0.7}, 1.3},
                                         Case{"rgbd_near", false, {0.1, 0.2, -1}, 0.8},
                                         Case{"rgbd_far", false, {0.3, -0.2, -1}, 3.5},
                                         Case{"rgbd_floor", false, {0, -1, -0.7}, 1.3}),
                         [](const auto& test) { return test.param.name; });

// A box in front of a wall: at its border neither normals nor depths may be taken from both.
class EdgeTest : public testing::TestWithParam<bool> {
 protected:
  EdgeTest() : head(GetParam() ? tof_head() : registered_head()) {
    scene.planes.push_back({{0, 0, -1}, -2.5});
    scene.boxes.emplace_back(Eigen::Vector3d(-0.4, -0.3, 1.5), Eigen::Vector3d(0.3, 0.3, 1.6));
    registered = register_depth(frame_of(render(scene, head.depth, head.T_colour_depth)), head);
  }
  RgbdCalibration head;
  Scene scene;
  RegisteredDepth registered;
};

TEST_P(EdgeTest, NormalsDoNotMixBoxAndWall) {
  const cv::Mat normals = estimate_normals(registered);
  int known = 0;
  for (int v = 0; v < normals.rows; ++v) {
    for (int u = 0; u < normals.cols; ++u) {
      const auto& n = normals.at<cv::Vec3f>(v, u);
      const auto& p = registered.points.at<cv::Vec3f>(v, u);
      // The box's sides are seen edge-on by the depth camera: leave out what is neither front nor wall.
      if (!is_valid(n) || (std::abs(p[2] - 1.5f) > 0.005f && std::abs(p[2] - 2.5f) > 0.005f)) continue;
      ++known;
      ASSERT_LT(n[2], -0.97f) << "pixel " << u << " " << v;
    }
  }
  EXPECT_GT(known, static_cast<int>(normals.total()) * 9 / 10);
}

TEST_P(EdgeTest, DepthIsOfTheBoxOrOfTheWallAndNeverBetween) {
  std::vector<cv::Point2f> pixels;
  for (float v = 100.25f; v < 380; v += 1.7f)
    for (float u = 130.25f; u < 500; u += 1.3f) pixels.emplace_back(u, v);
  const auto depths = depth_at_pixels(registered, head, pixels);
  int found = 0;
  for (const auto& depth : depths) {
    const float z = depth.point.z();
    if (std::isnan(z)) continue;
    ++found;
    const bool box = z > 1.495f && z < 1.605f;
    const bool wall = std::abs(z - 2.5f) < 0.005f;
    ASSERT_TRUE(box || wall) << z;
  }
  EXPECT_GT(found, static_cast<int>(pixels.size()) * 8 / 10);
}

INSTANTIATE_TEST_SUITE_P(ToFAndRegistered, EdgeTest, testing::Bool());

TEST(DepthAtPixels, NothingOutsideTheImageOrInAHole) {
  const RgbdCalibration head = registered_head();
  cv::Mat depth(480, 640, CV_16UC1, cv::Scalar(1500));
  depth(cv::Rect(100, 100, 20, 20)) = 0;
  const auto registered = register_depth(frame_of(depth), head);
  const float nan = std::nanf("");
  const auto depths = depth_at_pixels(
      registered, head, {{110, 110}, {-1, 5}, {640, 5}, {5, 1e9f}, {nan, 5}, {300, 300}, {99.9f, 110}});
  for (std::size_t i : {0u, 1u, 2u, 3u, 4u}) EXPECT_TRUE(std::isnan(depths[i].point.x())) << i;
  EXPECT_NEAR(depths[5].point.z(), 1.5, 1e-4);
  EXPECT_TRUE(depth_at_pixels(registered, head, {}).empty());
}

TEST(Cloud, ColoursComeFromThePixelsUnderThePoints) {
  RgbdCalibration head = tof_head();
  head.T_colour_depth.translation().x() = 0.6;
  Scene scene;
  scene.planes.push_back({{0, 0, -1}, -2});
  RgbdFrame frame = frame_of(render(scene, head.depth, head.T_colour_depth));
  // Colour encodes the position: the left half is blue, the lower half is red.
  frame.colour = cv::Mat(480, 640, CV_8UC3);
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u)
      frame.colour.at<cv::Vec3b>(v, u) = cv::Vec3b(u < 320 ? 255 : 0, 0, v < 240 ? 0 : 255);
  const auto registered = register_depth(frame, head);
  const ColouredCloud cloud = make_cloud(frame, registered);
  ASSERT_GT(cloud.size(), 10000u);
  ASSERT_EQ(cloud.colours.size(), cloud.size());
  ASSERT_EQ(cloud.normals.size(), cloud.size());
  ASSERT_EQ(cloud.sigmas.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto pixel = head.colour.project(cloud.points[i].cast<double>());
    ASSERT_TRUE(pixel.has_value());
    if (std::abs(pixel->x() - 319.5) < 0.01 || std::abs(pixel->y() - 239.5) < 0.01) continue;
    ASSERT_EQ(cloud.colours[i], cv::Vec3b(pixel->x() < 319.5 ? 255 : 0, 0, pixel->y() < 239.5 ? 0 : 255));
  }
  // Points that the colour camera does not see are grey, and only there when asked for.
  const ColouredCloud all = make_cloud(frame, registered, 1, true);
  EXPECT_EQ(all.size(), registered.points.total());
  EXPECT_LT(cloud.size(), all.size());
  const auto grey = std::count(all.colours.begin(), all.colours.end(), cv::Vec3b(128, 128, 128));
  EXPECT_EQ(static_cast<std::size_t>(grey), all.size() - cloud.size());
  // Every third row and column.
  EXPECT_EQ(make_cloud(frame, registered, 3, true).size(), 59u * 48u);
  EXPECT_THROW(make_cloud(frame, registered, 0), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

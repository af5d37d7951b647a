#include <lcmslam/simulation/colour_camera.hpp>

#include <gmock/gmock.h>

#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

CameraModel distorted_model() {
  CameraModel camera = pinhole_camera(640, 480, 554);
  camera.distortion = {-0.12, 0.05, 0.0005, -0.0003, 0};
  return camera;
}

/// Centre of the red pixels, and how many there are.
cv::Point3d red_centre(const cv::Mat& image) {
  double x = 0, y = 0, weight = 0;
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const cv::Vec3b& pixel = image.at<cv::Vec3b>(v, u);
      const double redness = pixel[2] - 1.0 * pixel[1];
      if (redness < 60) continue;
      x += redness * u, y += redness * v, weight += redness;
    }
  return {x / weight, y / weight, weight};
}

/// A red disc that faces the camera, its centre 2.95 m ahead.
std::string disc_at(double y, double z) {
  return "cylinders: [{at: [2.952, " + std::to_string(y) + ", " + std::to_string(z) +
         "], pitch: -90, radius: 0.06, height: 0.002, material: red}]\n";
}

// A small target at a known place appears where the calibrated camera model puts it.
TEST(ColourCamera, AgreesWithTheCameraModel) {
  const CameraModel camera = distorted_model();
  for (const auto& [y, z] : {std::pair{0.0, 1.5}, {1.3, 2.4}, {-1.3, 2.4}, {1.3, 0.6}, {-1.4, 0.7}}) {
    const Scene scene = box_room(3, disc_at(y, z));
    const RayCaster caster(scene);
    const ColourCamera renderer(scene, caster, camera);
    const cv::Mat image = renderer.render(level_camera(), PixelNoise(1, 1, 0), 1);
    const auto expected = camera.project(level_camera().inverse() * Eigen::Vector3d(2.95, y, z));
    ASSERT_TRUE(expected.has_value());
    const cv::Point3d found = red_centre(image);
    EXPECT_NEAR(found.x, expected->x(), 0.3);
    EXPECT_NEAR(found.y, expected->y(), 0.3);
  }
}

TEST(ColourCamera, BlurSpreadsAnEdgeOverItsMotion) {
  const Scene scene =
      box_room(3, "panels: [{at: [2.99, 1.5, 0.5], yaw: 180, size: [3, 2], material: red}]\n");
  const RayCaster caster(scene);
  const CameraModel camera = pinhole_camera(640, 480, 554);
  const ColourCamera renderer(scene, caster, camera, {1.0 / 60, 0, 0, 0});
  const auto width = [&](double rate) {  // pixels between red and grey
    Vector6d velocity = Vector6d::Zero();
    velocity[4] = rate;
    const cv::Mat image = renderer.render({level_camera(), velocity}, PixelNoise(1, 1, 0), 1);
    int between = 0;
    for (int x = 250; x < 390; ++x) {
      const cv::Vec3b& pixel = image.at<cv::Vec3b>(240, x);
      between += pixel[1] > 24 && pixel[1] < 110;
    }
    return between;
  };
  EXPECT_EQ(width(0), 0);
  EXPECT_NEAR(width(1.0), 554 / 60.0, 2.5);  // 1 rad/s for 1/60 s
  EXPECT_NEAR(width(-0.5), 554 / 120.0, 2.5);
}

TEST(ColourCamera, NoiseHasThePinnedSize) {
  const Scene scene = box_room(3);
  const RayCaster caster(scene);
  const ColourSensor sensor;
  const ColourCamera renderer(scene, caster, pinhole_camera(640, 480, 554), sensor);
  const cv::Mat a = renderer.render(level_camera(), PixelNoise(1, 1, 0), 1);
  std::vector<double> values;
  for (int y = 200; y < 280; ++y)
    for (int x = 280; x < 360; ++x) values.push_back(a.at<cv::Vec3b>(y, x)[1]);
  const Moments m = moments(values);
  const double variance = sensor.read_sigma * sensor.read_sigma + sensor.shot_variance * m.mean + 1.0 / 12;
  EXPECT_NEAR(m.deviation, std::sqrt(variance), 0.1);
}

TEST(ColourCamera, SameBytesForEveryThreadCount) {
  const Scene scene = box_room(3, disc_at(0.3, 1.4));
  const RayCaster caster(scene);
  const ColourCamera renderer(scene, caster, distorted_model());
  Vector6d velocity;
  velocity << 0.1, 0, 0.4, 0, 0.5, 0;
  const PixelNoise noise(3, 1, 123);
  const cv::Mat one = renderer.render({level_camera(), velocity}, noise, 1);
  const cv::Mat three = renderer.render({level_camera(), velocity}, noise, 3);
  EXPECT_EQ(cv::norm(one, three, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace lcmslam

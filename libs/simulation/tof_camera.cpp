#include <lcmslam/simulation/tof_camera.hpp>

#include <algorithm>
#include <cmath>
#include <complex>

#include <lcmslam/parallel/rows.hpp>
#include <lcmslam/simulation/surface.hpp>

namespace lcmslam {
using Eigen::Vector3f;

namespace {

// A phase tells a range but for whole turns.
double folded(double range, double turn) {
  return range - turn * std::floor(range / turn);
}

}  // namespace

TofCamera::TofCamera(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
                     const TofSensor& sensor)
    : scene_(scene), caster_(caster), camera_(camera), sensor_(sensor) {
  const int split = sensor_.sub_rays;
  sub_rays_.create(split * camera.height, split * camera.width, CV_32FC3);
  for (int y = 0; y < sub_rays_.rows; ++y)
    for (int x = 0; x < sub_rays_.cols; ++x) {
      const Eigen::Vector2d pixel((x + 0.5) / split - 0.5, (y + 0.5) / split - 0.5);
      const Vector3f ray = camera.ray(pixel).normalized().cast<float>();
      sub_rays_.at<cv::Vec3f>(y, x) = {ray.x(), ray.y(), ray.z()};
    }
  cosine_.create(camera.height, camera.width, CV_32FC1);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      cosine_.at<float>(y, x) = static_cast<float>(1 / camera.ray(Eigen::Vector2d(x, y)).norm());
}

cv::Mat TofCamera::see(const Eigen::Isometry3d& T_world_camera, int threads) const {
  cv::Mat seen(camera_.height, camera_.width, CV_64FC2);
  const Eigen::Isometry3f T = T_world_camera.cast<float>();
  interleaved_rows(camera_.height, threads, [&](int row) {
    std::vector<std::vector<Echo>> sub_rows(static_cast<std::size_t>(sensor_.sub_rays));
    for (int k = 0; k < sensor_.sub_rays; ++k)
      trace_row(sensor_.sub_rays * row + k, T, sub_rows[static_cast<std::size_t>(k)]);
    sum_row(row, sub_rows.data(), seen);
  });
  return seen;
}

TofImage TofCamera::measure(const cv::Mat& seen, const PixelNoise& noise, int threads) const {
  const cv::Size size = seen.size();
  TofImage image{cv::Mat(size, CV_16UC1), cv::Mat(size, CV_8UC1), cv::Mat(size, CV_32FC1)};
  interleaved_rows(size.height, threads, [&](int row) { measure_row(row, seen, noise, image); });
  return image;
}

void TofCamera::trace_row(int sub_row, const Eigen::Isometry3f& T_world_camera,
                          std::vector<Echo>& echoes) const {
  const auto* ray = sub_rays_.ptr<cv::Vec3f>(sub_row);
  const Eigen::Matrix3f R = T_world_camera.linear();
  const Vector3f origin = T_world_camera.translation();
  const auto sub_pixel_angle = static_cast<float>(1 / (sensor_.sub_rays * camera_.fx));
  const int count = sub_rays_.cols;
  echoes.assign(static_cast<std::size_t>(count), Echo());
  RayPacket rays;
  for (int left = 0; left < count; left += RayPacket::size) {
    for (int i = 0; i < RayPacket::size; ++i) {
      const cv::Vec3f& d = ray[std::min(left + i, count - 1)];
      const Vector3f direction = R * Vector3f(d[0], d[1], d[2]);
      rays.x[i] = direction.x(), rays.y[i] = direction.y(), rays.z[i] = direction.z();
    }
    caster_.cast(origin, rays);
    for (int i = 0; i < RayPacket::size && left + i < count; ++i) {
      if (rays.triangle[i] == RayPacket::none) continue;
      const SceneTriangle& triangle = scene_.triangles[rays.triangle[i]];
      const Vector3f direction(rays.x[i], rays.y[i], rays.z[i]);
      const Vector3f normal = facing_normal(triangle, rays.u[i], rays.v[i], direction);
      const float range = rays.range[i], cosine = -normal.dot(direction);
      const float infrared =
          reflectivity(scene_, triangle, rays.u[i], rays.v[i], sub_pixel_angle * range)[3] / 255;
      echoes[static_cast<std::size_t>(left + i)] = {range, infrared * cosine / (range * range)};
    }
  }
}

bool TofCamera::is_lit(int row, int column) const {
  return static_cast<double>(cosine_.at<float>(row, column)) >= std::cos(sensor_.valid_angle);
}

void TofCamera::sum_row(int row, const std::vector<Echo>* sub_rows, cv::Mat& seen) const {
  const int split = sensor_.sub_rays;
  const double phase_per_metre = 2 * M_PI / sensor_.unambiguous_range;
  for (int column = 0; column < camera_.width; ++column) {
    // Phases relative to the first echo, so that the sum's angle does not wrap near 7.5 m.
    const double reference = sub_rows[0][static_cast<std::size_t>(split * column)].range;
    double real = 0, imaginary = 0;
    for (int k = 0; k < split; ++k)
      for (int i = 0; i < split; ++i) {
        const Echo& echo = sub_rows[k][static_cast<std::size_t>(split * column + i)];
        const auto phase =
            static_cast<float>(phase_per_metre * (static_cast<double>(echo.range) - reference));
        real += static_cast<double>(echo.signal * std::cos(phase));
        imaginary += static_cast<double>(echo.signal * std::sin(phase));
      }
    seen.at<cv::Vec2d>(row, column) = {reference + std::atan2(imaginary, real) / phase_per_metre,
                                       std::hypot(real, imaginary) / (split * split)};
  }
}

void TofCamera::measure_row(int row, const cv::Mat& seen, const PixelNoise& noise, TofImage& image) const {
  for (int column = 0; column < camera_.width; ++column) {
    const double range = seen.at<cv::Vec2d>(row, column)[0], amplitude = seen.at<cv::Vec2d>(row, column)[1];
    image.amplitude.at<float>(row, column) = static_cast<float>(amplitude);
    image.depth.at<std::uint16_t>(row, column) = 0;
    image.grey.at<std::uint8_t>(row, column) = 0;
    if (amplitude < sensor_.minimum_amplitude || !is_lit(row, column)) continue;
    const double reflected = amplitude * range * range;  // reflectivity x cos
    const double sigma = sensor_.noise * range * range / std::sqrt(reflected);
    const std::uint64_t bits = noise.bits(static_cast<std::uint64_t>(row * camera_.width + column));
    const double wiggle =
        sensor_.wiggle * std::sin(2 * M_PI * range / sensor_.wiggle_period + sensor_.wiggle_phase);
    const double noisy = range + wiggle + sigma * static_cast<double>(PixelNoise::smooth_normal(bits));
    const double measured = sensor_.folds ? folded(noisy, sensor_.unambiguous_range) : noisy;
    if (measured < sensor_.minimum_range || measured > sensor_.unambiguous_range) continue;
    const double depth = 1000 * measured * static_cast<double>(cosine_.at<float>(row, column));
    image.depth.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(depth + 0.5);
    image.grey.at<std::uint8_t>(row, column) =
        static_cast<std::uint8_t>(std::clamp(255 * amplitude * measured * measured + 0.5, 1.0, 255.0));
  }
}

}  // namespace lcmslam

#include <lcmslam/simulation/colour_camera.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/parallel/rows.hpp>
#include <lcmslam/simulation/surface.hpp>

namespace lcmslam {

using Eigen::Vector3f;

namespace {
/// Nearest whole number of a small one; much quicker than std::lround.
int nearest(float value) {
  return static_cast<int>(value + 1024.5f) - 1024;
}
}  // namespace

ColourCamera::ColourCamera(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
                           const ColourSensor& sensor)
    : scene_(scene), caster_(caster), camera_(camera), sensor_(sensor) {
  ray_table(camera).convertTo(rays_, CV_32F);
  for (std::size_t value = 0; value < sigma_.size(); ++value)
    sigma_[value] = static_cast<float>(
        std::sqrt(sensor.read_sigma * sensor.read_sigma + sensor.shot_variance * static_cast<double>(value)));
}

cv::Mat ColourCamera::see(const RowPoses& poses, int threads) const {
  static_assert(sizeof(Seen) == 5 * sizeof(float));
  cv::Mat seen(camera_.height, camera_.width, CV_32FC(5));
  interleaved_rows(camera_.height, threads,
                   [&](int row) { trace_row(row, poses.at(row, camera_.height).cast<float>(), seen); });
  return seen;
}

cv::Mat ColourCamera::expose(const cv::Mat& seen, const Vector6d& velocity, const PixelNoise& noise,
                             int threads, float exposed) const {
  const cv::Size size = seen.size();
  cv::Mat sharp(size, CV_8UC3), image(size, CV_8UC3);
  const auto last = static_cast<std::uint64_t>(size.area());
  const float gain =
      exposed * (1 + static_cast<float>(sensor_.gain_sigma) * PixelNoise::normal(noise.bits(last)));
  interleaved_rows(size.height, threads, [&](int row) { expose_row(row, seen, gain, sharp); });
  interleaved_rows(size.height, threads, [&](int row) {
    blur_row(row, velocity, sharp, seen, image);
    noise_row(row, noise, image);
  });
  return image;
}

ColourCamera::Seen ColourCamera::see(const RayPacket& rays, int i, const Vector3f& origin) const {
  const float pixel_angle = static_cast<float>(1 / camera_.fx);
  const SceneTriangle& triangle = scene_.triangles[rays.triangle[i]];
  const Vector3f direction(rays.x[i], rays.y[i], rays.z[i]);
  const Vector3f normal = facing_normal(triangle, rays.u[i], rays.v[i], direction);
  const float length = direction.norm(), cosine = -normal.dot(direction) / length;
  // Across the slope the pixel covers more of the surface; the geometric mean of both directions.
  const float footprint = pixel_angle * rays.range[i] * length / std::sqrt(std::max(cosine, 0.05f));
  const cv::Vec4f colour = reflectivity(scene_, triangle, rays.u[i], rays.v[i], footprint);
  return {light_at(scene_, origin + rays.range[i] * direction, normal),
          {colour[0], colour[1], colour[2]},
          rays.range[i]};  // directions have length 1 along the optical axis
}

double ColourCamera::brightness(const Eigen::Isometry3d& T_world_camera) const {
  constexpr int apart = 40;  // pixels
  const Eigen::Matrix3f R = T_world_camera.linear().cast<float>();
  const Vector3f origin = T_world_camera.translation().cast<float>();
  double sum = 0;
  int count = 0;
  for (int row = apart / 2; row < camera_.height; row += apart)
    for (int left = apart / 2; left < camera_.width; left += apart * RayPacket::size) {
      RayPacket rays;
      for (int i = 0; i < RayPacket::size; ++i) {
        const auto& ray = rays_.at<cv::Vec2f>(row, std::min(left + i * apart, camera_.width - 1));
        const Vector3f direction = R * Vector3f(ray[0], ray[1], 1);
        rays.x[i] = direction.x(), rays.y[i] = direction.y(), rays.z[i] = direction.z();
      }
      caster_.cast(origin, rays);
      for (int i = 0; i < RayPacket::size; ++i) {
        ++count;
        if (rays.triangle[i] == RayPacket::none) continue;
        const Seen seen = see(rays, i, origin);
        sum += static_cast<double>(seen.light * (seen.colour[0] + seen.colour[1] + seen.colour[2]) / 3);
      }
    }
  return sum / std::max(1, count);
}

void ColourCamera::trace_row(int row, const Eigen::Isometry3f& T_world_camera, cv::Mat& seen) const {
  const auto* ray = rays_.ptr<cv::Vec2f>(row);
  auto* pixel = seen.ptr<Seen>(row);
  const Eigen::Matrix3f R = T_world_camera.linear();
  const Vector3f origin = T_world_camera.translation();
  RayPacket rays;
  for (int left = 0; left < camera_.width; left += RayPacket::size) {
    rays.aim(ray, left, camera_.width, R);
    caster_.cast(origin, rays);
    for (int i = 0; i < RayPacket::size && left + i < camera_.width; ++i)
      pixel[left + i] = rays.triangle[i] == RayPacket::none ? Seen{0, {0, 0, 0}, 100} : see(rays, i, origin);
  }
}

void ColourCamera::expose_row(int row, const cv::Mat& seen, float gain, cv::Mat& sharp) const {
  const auto* light = seen.ptr<Seen>(row);
  auto* pixel = sharp.ptr<cv::Vec3b>(row);
  for (int column = 0; column < sharp.cols; ++column)
    for (int c = 0; c < 3; ++c)
      pixel[column][c] = static_cast<std::uint8_t>(
          std::min(255.f, gain * light[column].light * light[column].colour[c] + 0.5f));
}

// Averages along each pixel's path in the image during the exposure. A point p in the camera frame
// moves with -(v + w x p).
void ColourCamera::blur_row(int row, const Vector6d& velocity, const cv::Mat& sharp, const cv::Mat& seen,
                            cv::Mat& image) const {
  const auto* ray = rays_.ptr<cv::Vec2f>(row);
  const auto* surface = seen.ptr<Seen>(row);
  const auto* source = sharp.ptr<cv::Vec3b>(row);
  auto* pixel = image.ptr<cv::Vec3b>(row);
  const Vector3f v = velocity.head<3>().cast<float>(), w = velocity.tail<3>().cast<float>();
  const auto along_x = static_cast<float>(sensor_.exposure * camera_.fx);
  const auto along_y = static_cast<float>(sensor_.exposure * camera_.fy);
  for (int column = 0; column < camera_.width; ++column) {
    const Vector3f direction(ray[column][0], ray[column][1], 1);
    const Vector3f flow = -(v / surface[column].depth + w.cross(direction));
    const float dx = along_x * (flow.x() - direction.x() * flow.z());
    const float dy = along_y * (flow.y() - direction.y() * flow.z());
    const float length = std::max(std::abs(dx), std::abs(dy));
    const int half = std::min(static_cast<int>(0.5f * length + 0.5f), 8);
    if (half == 0) {
      pixel[column] = source[column];
      continue;
    }
    const float step_x = dx / static_cast<float>(2 * half + 1),
                step_y = dy / static_cast<float>(2 * half + 1);
    int sum[3] = {0, 0, 0};
    for (int tap = -half; tap <= half; ++tap) {
      const float t = static_cast<float>(tap);
      const int x = std::clamp(column + nearest(t * step_x), 0, camera_.width - 1);
      const int y = std::clamp(row + nearest(t * step_y), 0, camera_.height - 1);
      const cv::Vec3b& value = sharp.ptr<cv::Vec3b>(y)[x];
      for (int c = 0; c < 3; ++c) sum[c] += value[c];
    }
    const int taps = 2 * half + 1;
    for (int c = 0; c < 3; ++c) pixel[column][c] = static_cast<std::uint8_t>((sum[c] + half) / taps);
  }
}

void ColourCamera::noise_row(int row, const PixelNoise& noise, cv::Mat& image) const {
  auto* pixel = image.ptr<cv::Vec3b>(row);
  for (int column = 0; column < camera_.width; ++column) {
    std::uint64_t bits = noise.bits(static_cast<std::uint64_t>(row * camera_.width + column));
    for (int c = 0; c < 3; ++c, bits >>= 16) {
      const float value =
          static_cast<float>(pixel[column][c]) + sigma_[pixel[column][c]] * PixelNoise::normal(bits);
      pixel[column][c] = static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.f, 255.f));
    }
  }
}

}  // namespace lcmslam

#include <lcmslam/simulation/depth_camera.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/parallel/rows.hpp>
#include <lcmslam/simulation/surface.hpp>

namespace lcmslam {

using Eigen::Vector3f;

DepthCamera::DepthCamera(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
                         const StructuredLightSensor& sensor)
    : scene_(scene), caster_(caster), camera_(camera), sensor_(sensor) {
  ray_table(camera).convertTo(rays_, CV_32F);
}

cv::Mat DepthCamera::see(const RowPoses& poses, int threads) const {
  cv::Mat exact(camera_.height, camera_.width, CV_32FC2);
  interleaved_rows(camera_.height, threads,
                   [&](int row) { trace_row(row, poses.at(row, camera_.height).cast<float>(), exact); });
  return exact;
}

cv::Mat DepthCamera::measure(const cv::Mat& seen, const PixelNoise& noise, int threads) const {
  cv::Mat depth(seen.size(), CV_16UC1);
  interleaved_rows(depth.rows, threads, [&](int row) { measure_row(row, seen, noise, depth); });
  return depth;
}

// Exact depth along the optical axis and cosine of the incidence angle.
void DepthCamera::trace_row(int row, const Eigen::Isometry3f& T_world_camera, cv::Mat& exact) const {
  const auto* ray = rays_.ptr<cv::Vec2f>(row);
  auto* result = exact.ptr<cv::Vec2f>(row);
  const Eigen::Matrix3f R = T_world_camera.linear();
  const Vector3f origin = T_world_camera.translation();
  RayPacket rays;
  for (int left = 0; left < camera_.width; left += RayPacket::size) {
    rays.aim(ray, left, camera_.width, R);
    caster_.cast(origin, rays);
    for (int i = 0; i < RayPacket::size && left + i < camera_.width; ++i) {
      result[left + i] = {1000, 0};
      if (rays.triangle[i] == RayPacket::none) continue;
      const Vector3f direction(rays.x[i], rays.y[i], rays.z[i]);
      const Vector3f normal =
          facing_normal(scene_.triangles[rays.triangle[i]], rays.u[i], rays.v[i], direction);
      result[left + i] = {rays.range[i], -normal.dot(direction) / direction.norm()};
    }
  }
}

// Standard normal. Between nodes `correlation` pixels apart it is interpolated, and scaled so that its
// variance stays 1: weights w give a variance of the sum of w^2.
double DepthCamera::noise_at(const PixelNoise& noise, int column, int row) const {
  const auto node = [&](int x, int y) {
    const auto bits = noise.bits(static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(camera_.width) +
                                 static_cast<std::uint64_t>(x));
    return static_cast<double>(PixelNoise::smooth_normal(bits));
  };
  const int apart = sensor_.correlation;
  if (apart == 1) return node(column, row);
  const int x = column / apart, y = row / apart;
  const double right = static_cast<double>(column % apart) / apart, left = 1 - right;
  const double lower = static_cast<double>(row % apart) / apart, upper = 1 - lower;
  const double sum = upper * (left * node(x, y) + right * node(x + 1, y)) +
                     lower * (left * node(x, y + 1) + right * node(x + 1, y + 1));
  return sum / std::sqrt((upper * upper + lower * lower) * (left * left + right * right));
}

void DepthCamera::measure_row(int row, const cv::Mat& exact, const PixelNoise& noise, cv::Mat& depth) const {
  const auto at = [&](int x, int y) {
    return exact.at<cv::Vec2f>(std::clamp(y, 0, exact.rows - 1), std::clamp(x, 0, exact.cols - 1));
  };
  const double disparity_metres = camera_.fx * sensor_.baseline;  // disparity x depth
  for (int column = 0; column < camera_.width; ++column) {
    auto& value = depth.at<std::uint16_t>(row, column);
    value = 0;
    const double z = static_cast<double>(at(column, row)[0]);
    const double cosine = static_cast<double>(at(column, row)[1]);
    if (cosine < sensor_.grazing_cosine || z < sensor_.minimum || z > sensor_.maximum) continue;
    // The projector's rays miss what lies just behind an edge.
    bool edge = false;
    for (const auto& [dx, dy] :
         {std::pair{-2, 0}, {2, 0}, {0, -2}, {0, 2}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}})
      edge = edge || z - static_cast<double>(at(column + dx, row + dy)[0]) > sensor_.edge_ratio * z;
    if (edge) continue;
    const double noisy = z + sensor_.sigma(z, camera_.fx) * noise_at(noise, column, row);
    const double steps = std::round(disparity_metres / noisy / sensor_.disparity_step);
    const double measured = disparity_metres / (steps * sensor_.disparity_step);
    if (measured >= sensor_.minimum && measured <= sensor_.maximum)
      value = static_cast<std::uint16_t>(1000 * measured + 0.5);
  }
}

}  // namespace lcmslam

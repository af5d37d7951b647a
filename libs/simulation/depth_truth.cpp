#include <lcmslam/simulation/depth_truth.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include <lcmslam/parallel/rows.hpp>
#include <lcmslam/simulation/surface.hpp>

namespace lcmslam {
namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
constexpr float steepest = 5.67f;   // 80 degrees of incidence: a smooth surface no steeper than this
constexpr float rounding = 0.001f;  // m

/// Sets of connected sub-rays (union-find).
class Components {
 public:
  explicit Components(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::size_t root(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    parent_[std::max(root(a), root(b))] = std::min(root(a), root(b));
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace

DepthTolerance noise_tolerance(const TofSensor& sensor) {
  return [sensor](double z, double amplitude) {
    return 3 * sensor.noise * z * z / std::sqrt(std::max(amplitude, 1.0 / 255)) + sensor.wiggle;
  };
}

DepthTolerance noise_tolerance(const StructuredLightSensor& sensor, double fx) {
  return [sensor, fx](double z, double) {
    return 3 * sensor.sigma(z, fx) + 0.5 * sensor.disparity_step * z * z / (fx * sensor.baseline);
  };
}

DepthTruth::DepthTruth(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
                       DepthTolerance tolerance, int split)
    : scene_(scene),
      caster_(caster),
      camera_(camera),
      tolerance_(std::move(tolerance)),
      split_(split),
      spacing_(static_cast<float>(1 / (split * std::min(camera.fx, camera.fy)))) {
  if (split < 1) throw std::invalid_argument("split must be at least 1");
  rays_.create(split * camera.height, split * camera.width, CV_32FC2);
  for (int y = 0; y < rays_.rows; ++y)
    for (int x = 0; x < rays_.cols; ++x) {
      const Eigen::Vector3d ray = camera.ray({(x + 0.5) / split - 0.5, (y + 0.5) / split - 0.5});
      rays_.at<cv::Vec2f>(y, x) = {static_cast<float>(ray.x()), static_cast<float>(ray.y())};
    }
}

void DepthTruth::trace_row(int sub_row, const Eigen::Isometry3f& T_world_camera, Hit* hits) const {
  const Eigen::Matrix3f R = T_world_camera.linear();
  const Eigen::Vector3f origin = T_world_camera.translation();
  RayPacket rays;
  for (int left = 0; left < rays_.cols; left += RayPacket::size) {
    rays.aim(rays_.ptr<cv::Vec2f>(sub_row), left, rays_.cols, R);
    caster_.cast(origin, rays);
    for (int i = 0; i < RayPacket::size && left + i < rays_.cols; ++i) {
      hits[left + i] = {std::numeric_limits<float>::infinity(), 0};
      if (rays.triangle[i] == RayPacket::none) continue;
      const Eigen::Vector3f direction(rays.x[i], rays.y[i], rays.z[i]);
      const Eigen::Vector3f normal =
          facing_normal(scene_.triangles[rays.triangle[i]], rays.u[i], rays.v[i], direction);
      const float cosine = std::clamp(-normal.dot(direction) / direction.norm(), 0.0f, 1.0f);
      const float sine = std::sqrt(1 - cosine * cosine);
      hits[left + i] = {rays.range[i], std::min(steepest, sine / std::max(cosine, 1e-3f))};
    }
  }
}

// Metres from z to the nearest surface among the pixel's sub-rays (its hits stand row by row).
float DepthTruth::gap_to_surfaces(const Hit* hits, float z, int& surfaces) const {
  const auto n = static_cast<std::size_t>(split_);
  Components components(n * n);
  const auto continues = [&](const Hit& a, const Hit& b) {
    const float step = spacing_ * std::min(a.z, b.z) * (a.slope + b.slope);
    return std::abs(a.z - b.z) <= step + rounding;  // false where both are infinite
  };
  for (std::size_t i = 0; i < n * n; ++i) {
    if (i % n + 1 < n && continues(hits[i], hits[i + 1])) components.join(i, i + 1);
    if (i + n < n * n && continues(hits[i], hits[i + n])) components.join(i, i + n);
  }
  float gap = std::numeric_limits<float>::infinity();
  surfaces = 0;
  for (std::size_t root = 0; root < n * n; ++root) {
    if (components.root(root) != root) continue;
    ++surfaces;
    float nearest = hits[root].z, farthest = nearest;
    for (std::size_t i = 0; i < n * n; ++i)
      if (components.root(i) == root) {
        nearest = std::min(nearest, hits[i].z);
        farthest = std::max(farthest, hits[i].z);
      }
    gap = std::min(gap, std::max({0.0f, nearest - z, z - farthest}));
  }
  return gap;
}

cv::Mat DepthTruth::classify(const cv::Mat& depth, const cv::Mat& amplitude,
                             const Eigen::Isometry3d& T_world_camera, int threads, cv::Mat* gap) const {
  const cv::Size size(camera_.width, camera_.height);
  if (depth.type() != CV_16UC1 || depth.size() != size ||
      (!amplitude.empty() && (amplitude.type() != CV_8UC1 || amplitude.size() != size)))
    throw std::invalid_argument("depth truth: images must have the camera's size, 16 and 8 bits");
  cv::Mat classes(size, CV_8UC1, cv::Scalar(0));
  if (gap != nullptr) *gap = cv::Mat(size, CV_32FC1, cv::Scalar(nothing));
  const Eigen::Isometry3f T = T_world_camera.cast<float>();
  interleaved_rows(size.height, threads, [&](int v) {
    std::vector<Hit> rows(static_cast<std::size_t>(split_ * rays_.cols));
    std::vector<Hit> pixel(static_cast<std::size_t>(split_ * split_));
    for (int k = 0; k < split_; ++k) trace_row(split_ * v + k, T, rows.data() + k * rays_.cols);
    for (int u = 0; u < size.width; ++u) {
      if (depth.at<std::uint16_t>(v, u) == 0) continue;
      for (int k = 0; k < split_; ++k)
        std::copy_n(rows.begin() + k * rays_.cols + u * split_, split_, pixel.begin() + k * split_);
      const double z = 0.001 * depth.at<std::uint16_t>(v, u);
      const double relative = amplitude.empty() ? 1.0 : amplitude.at<std::uint8_t>(v, u) / 255.0;
      int surfaces = 0;
      const float ratio = gap_to_surfaces(pixel.data(), static_cast<float>(z), surfaces) /
                          static_cast<float>(tolerance_(z, relative));
      if (gap != nullptr) gap->at<float>(v, u) = ratio;
      const DepthClass judged = ratio <= 1     ? DepthClass::good
                                : surfaces > 1 ? DepthClass::mixed
                                               : DepthClass::off;
      classes.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(judged);
    }
  });
  return classes;
}

}  // namespace lcmslam

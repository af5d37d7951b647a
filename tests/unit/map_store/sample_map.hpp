#pragma once
// Maps that the tests share, made from seeds.

#include <stdlib.h>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/map_store/landmark_map.hpp>

namespace lcmslam {

inline Eigen::Vector3d random_point(Random& random, double half = 2) {
  Eigen::Vector3d point;
  for (int axis = 0; axis < 3; ++axis) point[axis] = random.uniform(-half, half);
  return point;
}

inline ColouredCloud random_cloud(std::uint64_t seed, std::size_t size, bool normals) {
  Random random(seed);
  ColouredCloud cloud;
  for (std::size_t i = 0; i < size; ++i) {
    cloud.points.emplace_back(random_point(random).cast<float>());
    const auto channel = [&] { return static_cast<uchar>(random.below(256)); };
    const uchar blue = channel(), green = channel(), red = channel();
    cloud.colours.emplace_back(blue, green, red);
    if (normals) cloud.normals.emplace_back(random_point(random).normalized().cast<float>());
  }
  return cloud;
}

inline Eigen::Isometry3d random_pose(Random& random) {
  Vector6d twist;
  twist << random_point(random), random_point(random, 1);
  return se3_exp(twist);
}

inline Landmark landmark(std::int64_t id, double x = 0, double y = 0, double z = 0) {
  Landmark result;
  result.id = id;
  result.mean = {x, y, z};
  result.covariance = 0.01 * Eigen::Matrix3d::Identity();
  result.observations = 3;
  result.colour = {10, 200, 30};
  return result;
}

/// A folder of its own for one test, removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mapping_test_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace lcmslam

#pragma once
// Recorded clouds with known transforms. Every function returns nothing where the data is absent.

#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>
#include <string>

#include <lcmslam/cloud/cloud_normals.hpp>
#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/support/recordings.hpp"

namespace lcmslam {

/// Two clouds of one scene, normals included, and the transform between them.
struct RecordedPair {
  Cloud source, target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
};

/// Binary PLY of x, y, z floats (little-endian).
inline std::vector<Eigen::Vector3f> read_ply(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  std::size_t count = 0;
  std::size_t floats = 0;
  while (std::getline(in, line) && line.rfind("end_header", 0) != 0) {
    if (line.rfind("element vertex ", 0) == 0) count = std::stoul(line.substr(15));
    if (line.rfind("property float", 0) == 0) ++floats;
  }
  std::vector<Eigen::Vector3f> points;
  std::vector<float> row(floats);
  for (std::size_t i = 0; i < count; ++i) {
    in.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(floats * sizeof(float)));
    if (!in) return {};
    points.emplace_back(row.at(0), row.at(1), row.at(2));
  }
  return points;
}

/// An outdoor LiDAR pair (small_gicp) at 0.4 m.
inline std::optional<RecordedPair> lidar_pair() {
  const auto folder = recording_path("registration/small_gicp/data");
  if (!std::filesystem::exists(folder / "source.ply")) return std::nullopt;
  RecordedPair pair;
  pair.source.points = read_ply(folder / "source.ply");
  pair.target.points = read_ply(folder / "target.ply");
  std::ifstream in(folder / "T_target_source.txt");
  for (int i = 0; i < 16; ++i) in >> pair.T_target_source.matrix()(i / 4, i % 4);
  pair.source = voxel_filtered(pair.source, 0.4);
  pair.target = voxel_filtered(pair.target, 0.25);
  estimate_normals(pair.source, Eigen::Vector3d::Zero());
  estimate_normals(pair.target, Eigen::Vector3d::Zero());
  return pair;
}

/// Images 4 and 5 of slambook2's five, the book's poses: 0.4 m apart, approximate (3 cm).
inline std::optional<RecordedPair> slambook2_pair() {
  const auto folder = recording_path("rgbd_slambook2");
  if (!std::filesystem::exists(folder / "pose.txt")) return std::nullopt;
  RgbdCalibration calibration;
  calibration.depth_registered = true;
  calibration.colour.width = 640;
  calibration.colour.height = 480;
  calibration.colour.fx = 518, calibration.colour.fy = 519;
  calibration.colour.cx = 325.5, calibration.colour.cy = 253.5;
  calibration.depth = calibration.colour;
  std::vector<Eigen::Isometry3d> poses;
  std::ifstream in(folder / "pose.txt");
  for (double p[3], q[4]; in >> p[0] >> p[1] >> p[2] >> q[1] >> q[2] >> q[3] >> q[0];)
    poses.push_back(make_transform(p, q));
  const auto cloud = [&](int number, double voxel_size) {
    RgbdFrame frame;
    const std::string name = std::to_string(number);
    frame.depth = cv::imread((folder / "depth" / (name + ".pgm")).string(), cv::IMREAD_UNCHANGED);
    frame.colour = cv::imread((folder / "color" / (name + ".png")).string());
    const ColouredCloud dense = make_cloud(frame, register_depth(frame, calibration), 3);
    return voxel_filtered(geometry_of(dense), voxel_size);
  };
  return RecordedPair{cloud(5, 0.05), cloud(4, 0.03), poses.at(3).inverse() * poses.at(4)};
}

/// The hand-held recording tum_fr1_rpy.
class Fr1Recording {
 public:
  static std::optional<Fr1Recording> open() {
    const auto folder = recording_path("tum_fr1_rpy");
    if (!std::filesystem::exists(folder / "associations.txt")) return std::nullopt;
    return Fr1Recording(folder);
  }

  std::size_t size() const { return frames_.size(); }
  Utime utime(std::size_t i) const { return static_cast<Utime>(frames_.at(i).seconds * 1e6); }

  /// Every `step`-th row and column, with normals, camera frame.
  ColouredCloud cloud(std::size_t i, int step = 4) const {
    RgbdFrame frame;
    const cv::Mat depth = cv::imread((folder_ / frames_.at(i).depth).string(), cv::IMREAD_UNCHANGED);
    depth.convertTo(frame.depth, CV_16U, 0.2);  // factor 5000 -> mm
    frame.colour = cv::imread((folder_ / frames_.at(i).colour).string());
    return make_cloud(frame, registration_(frame), step);
  }

  /// Motion capture, interpolated at the depth image's time; its clock is 27 ms ahead of the stamps.
  Eigen::Isometry3d T_world_camera(std::size_t i) const {
    const double t = frames_.at(i).seconds - 0.027;
    const auto after = truth_.lower_bound(t);
    const auto before = std::prev(after);
    return interpolate(before->second, after->second, (t - before->first) / (after->first - before->first));
  }

 private:
  struct Frame {
    double seconds;
    std::string colour, depth;
  };

  explicit Fr1Recording(const std::filesystem::path& folder) : folder_(folder), registration_(calibration()) {
    std::string line;
    std::ifstream associations(folder / "associations.txt");
    while (std::getline(associations, line)) {
      std::istringstream words(line);
      Frame f;
      double colour_seconds;
      if (words >> colour_seconds >> f.colour >> f.seconds >> f.depth) frames_.push_back(f);
    }
    std::ifstream truth(folder / "groundtruth.txt");
    while (std::getline(truth, line)) {
      std::istringstream words(line);
      double t, p[3], q[4];
      if (words >> t >> p[0] >> p[1] >> p[2] >> q[1] >> q[2] >> q[3] >> q[0])
        truth_[t] = make_transform(p, q);
    }
  }

  static RgbdCalibration calibration() {
    RgbdCalibration c;
    c.depth_registered = true;
    c.colour.width = 640;
    c.colour.height = 480;
    c.colour.fx = 517.3, c.colour.fy = 516.5, c.colour.cx = 318.6, c.colour.cy = 255.3;
    c.colour.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
    c.depth = c.colour;
    return c;
  }

  std::filesystem::path folder_;
  DepthRegistration registration_;
  std::vector<Frame> frames_;
  std::map<double, Eigen::Isometry3d> truth_;
};

}  // namespace lcmslam

#pragma once
// Recordings without images: odometry, and landmarks of known identity measured in the plane.
//
//   LandmarkRecording r = read_mrclam("../shared/data/mrclam_dataset6", 3, read_mrclam_sensor(yaml));
//   r.twists; r.frames; r.truth;

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/odometry/twist_odometry.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct LandmarkRecording {
  std::vector<Twist> twists;           ///< in order of time; empty when the odometry is a pose
  std::vector<MotionSample> odometry;  ///< accumulated poses with covariance; empty when it is a twist
  std::vector<FeatureFrame> frames;    ///< in order of time; some without a feature: nothing was seen
  // For evaluation only.
  Trajectory truth;                               ///< T_world_robot
  std::map<int, Eigen::Vector2d> landmark_truth;  ///< m, world, by identity
  std::vector<std::string> notes;                 ///< what was assumed
  std::vector<std::string> problems;              ///< "file:line: ..." of rows that were left out
};

/// How the Create robots' camera measures (config/datasets/mrclam.yaml says where the numbers are from).
struct MrclamSensor {
  bool range_along_axis = false;
  double range_offset = 0;
  double range_scale = 1;
  double range_sigma = 0.1;
  double range_sigma_per_m2 = 0;
  double bearing_sigma = 0.02;
  double frame_period = 0.5;

  void describe(SettingsVisitor& s) {
    s.flag("range_along_axis", range_along_axis,
           "ranges are measured along the optical axis, not along the ray");
    s.number("range_offset", range_offset, "m", {-1, 1}, "measured = offset + scale * true, after that");
    s.number("range_scale", range_scale, "", {0.5, 2}, "measured = offset + scale * true, after that");
    s.number("range_sigma", range_sigma, "m", {1e-4, 10}, "standard deviation of a range");
    s.number("range_sigma_per_m2", range_sigma_per_m2, "1/m", {0, 1}, "sigma grows by this times range^2");
    s.number("bearing_sigma", bearing_sigma, "rad", {1e-3, 1}, "standard deviation of a bearing");
    s.number("frame_period", frame_period, "s", {0.01, 4},
             "frames without features come so often where no landmark is seen");
  }
};

/// Of a description with the format mrclam. Throws ConfigError.
MrclamSensor load_mrclam_sensor(const std::filesystem::path& description);

/// Robots whose three files are in the folder, ascending; empty when it is no MRCLAM folder.
std::vector<int> mrclam_robots(const std::filesystem::path& folder);

/// One robot's run of a UTIAS MRCLAM folder (Leung et al., IJRR 2011): RobotN_Odometry, _Measurement and
/// _Groundtruth.dat, Barcodes.dat, Landmark_Groundtruth.dat. Identities are subject numbers; observations of
/// other robots (subjects 1 to 5) and of barcodes that nobody wears are left out and counted in notes.
/// Throws DatasetError.
LandmarkRecording read_mrclam(const std::filesystem::path& folder, int robot, const MrclamSensor& sensor);

struct VictoriaParkSettings {
  Utime start = 1'000'000'000'000'000;  ///< us, of the first pose; no key
  double period = 0.2;

  void describe(SettingsVisitor& s) {
    s.number("period", period, "s", {1e-3, 4}, "between poses: the file has no stamps");
  }
};

/// Of a description with the format victoria_park. Throws ConfigError.
VictoriaParkSettings load_victoria_park_settings(const std::filesystem::path& description);

/// Whether the file begins with a row ODOMETRY or LANDMARK.
bool is_victoria_park(const std::filesystem::path& file);

/// The Victoria Park file in iSAM's text form. Poses and landmarks share one index space:
///   ODOMETRY i j dx dy dtheta + 6 numbers, upper triangle of the increment's covariance (m^2, m rad, rad^2)
///   LANDMARK i l dx dy + 3 numbers, upper triangle of the offset's covariance (m^2)
/// Throws DatasetError with file, line and value for a row that is malformed or breaks the chain of
/// poses: what stands after it would have no place.
LandmarkRecording read_victoria_park(const std::filesystem::path& file,
                                     const VictoriaParkSettings& settings = {});

/// Whichever of both the path is (Victoria Park also by its folder), read as options.description or
/// config/datasets/{mrclam,victoria_park}.yaml say; nothing when it is neither. `robot` 0: the only one.
/// Throws DatasetError or ConfigError.
std::optional<LandmarkRecording> open_landmark_dataset(const std::filesystem::path& path, int robot = 0,
                                                       const DatasetOptions& options = {});

}  // namespace lcmslam

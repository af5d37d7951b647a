#pragma once
// One piece of a model of sensor head: what no calibration tells of it. Heads of one model are told alike and
// are not alike: a careful calibration leaves errors of these sizes, which the mappers are told to expect
// (FastSlamSettings::focal_sigma, stamp_sigma; MountErrorSettings).

#include <cstdint>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/simulation/tof_camera.hpp>

namespace lcmslam {

class HeadPiece {
 public:
  static constexpr double focal_sigma = 0.001;        ///< ratio, of each camera's focal lengths
  static constexpr double translation_sigma = 0.002;  ///< m, of the mount along each axis
  static constexpr double rotation_sigma = 0.001;     ///< rad, of the mount about each axis
  static constexpr double clock_sigma = 0.001;        ///< s, of both images' stamps against the wheels'

  /// `unit` numbers the pieces; 0 is just as it is told.
  explicit HeadPiece(std::uint64_t unit) : unit_(unit) {}

  /// The time-of-flight camera's range wiggles as far, at other ranges.
  TofSensor sensor(TofSensor model) const;
  /// The colour camera's and the depth camera's lens as they are.
  CameraModel colour(const CameraModel& told) const { return lens(told, 2); }
  CameraModel depth(const CameraModel& told) const { return lens(told, 3); }
  /// Where the head truly sits, T_robot_camera.
  Eigen::Isometry3d mount(const Eigen::Isometry3d& told) const;
  /// us by which its stamps are late.
  Utime clock() const;

 private:
  Random stream(std::uint64_t part) const { return Random(unit_, 0x756e6974 + (part << 32U)); }
  CameraModel lens(CameraModel told, std::uint64_t part) const;

  std::uint64_t unit_;
};

}  // namespace lcmslam

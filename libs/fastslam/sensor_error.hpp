#pragma once
// What a measurement of a landmark may err by, for each member of an error ensemble. Of the stated noise
//
//   a part is the depth camera's systematic error: alike for all that lies at one range, and another wave of
//   the range for each member;
//   a part is the feature's: it lies beside the corner, on the rim of a thing, and is found there again as
//   long as it is seen from the same side and distance;
//   the rest is new in every image.
//
// Blobs on edges slide along them as the robot goes by, most of them with it: all landmarks by a ratio of the
// way since they were first seen, and turned about the robot by an angle for each metre of it. Besides, the
// focal lengths are known as well as a calibration tells them, and so is the moment at which each row of the
// image was taken: what the robot moves by until then, everything seems to have moved.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include <lcmslam/fastslam/association/usable_features.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

constexpr int ensemble_size = 64;
/// One column a member.
using EnsembleRow = Eigen::Matrix<float, 1, ensemble_size>;
/// m or rad.
using EnsembleVectors = Eigen::Matrix<float, 3, ensemble_size, Eigen::RowMajor>;

/// +1 or -1 in each row's columns, by the bits of `words`.
EnsembleVectors random_signs(const std::uint64_t (&words)[3]);

class SensorError {
 public:
  explicit SensorError(const FastSlamSettings& settings);

  struct Landmark {
    int slot;         ///< in the index, of one landmark after the other
    std::int64_t id;  ///< never used twice
  };
  /// Of the value of one measurement; `T_world_robot`: from where, `twist`: the robot's velocity, m/s, rad/s,
  /// body frame.
  EnsembleVectors draw(const FeaturePoint& point, const FeatureFrame& frame, Landmark landmark,
                       const Eigen::Isometry3d& T_world_robot, const Vector6d& twist);

 private:
  EnsembleVectors of_point(const FeaturePoint& point, const FeatureFrame& frame, Landmark landmark,
                           const Eigen::Isometry3d& T_world_robot, const Vector6d& twist);
  EnsembleVectors of_plane(const Measurement& measurement);
  EnsembleRow depth_wave(double range) const;
  EnsembleVectors of_view(const Eigen::Vector3d& ray, std::int64_t landmark) const;
  Eigen::Vector3d way_since_first_seen(Landmark landmark, const Eigen::Isometry3d& T_world_robot);

  struct FirstView {
    std::int64_t landmark = -1;  // id
    Eigen::Vector3d from;        // m, world
  };

  FastSlamSettings settings_;
  Random stream_;
  std::uint64_t seed_;
  std::vector<EnsembleRow> depth_waves_;  // of unit variance, by range
  EnsembleRow focal_x_, focal_y_;         // ratios
  EnsembleRow stamp_, shutter_;           // s: of the image, and from its first row to its last
  EnsembleRow slide_;                     // ratio
  EnsembleRow bend_;                      // rad/m
  std::vector<FirstView> first_views_;    // by slot
};

}  // namespace lcmslam

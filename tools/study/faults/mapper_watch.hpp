#pragma once
// What a mapper says of its pose while things go wrong, held against the truth.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {

class MapperWatch {
 public:
  /// `at`: s since the first frame, when it arrived.
  void add(const pose_estimate_t& message, double at = 0);

  std::size_t poses() const { return poses_.size(); }
  /// Maps that it began: senders and frames.
  std::size_t sessions() const;

  /// RMSE in m of the poses of its first map that it calls tracked, after the best alignment (SE(3)); NaN
  /// without any.
  double ate(const Trajectory& truth) const;

  struct FalseTracking {
    double seconds = 0;  ///< of the longest time
    Utime begin = 0;
    double error = 0;  ///< m, the largest meanwhile
  };
  /// The longest time that it says TRACKING while its position is more than `limit` (m) off. Each map is laid
  /// onto the truth by its poses until `undisturbed`, one that begins later by its first pose.
  FalseTracking longest_false_tracking(const Trajectory& truth, Utime undisturbed, double limit) const;

  /// A pose held against the truth, likewise.
  struct Held {
    double at = 0;
    bool tracking = false;
    double error = 0;  ///< m
    Utime utime = 0;
  };
  std::vector<Held> held(const Trajectory& truth, Utime undisturbed) const;

 private:
  struct Pose {
    double at = 0;
    Utime utime = 0;
    Eigen::Isometry3d T_map_robot = Eigen::Isometry3d::Identity();
    bool tracking = false;
    std::pair<std::int64_t, std::string> session;  // sender, frame
  };
  std::vector<Pose> poses_;
};

}  // namespace lcmslam

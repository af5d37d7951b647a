#pragma once
// The poses that a mapper stands for: what it says while it is lost is no claim that could be held against
// it, and what it says of a later map is in another frame.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

struct BelievedPath {
  Trajectory path;  ///< with covariances; of the first map, of status TRACKING, DEGRADED or RELOCALISED
  std::size_t left_out = 0;  ///< all other poses
};

/// Collects them from messages.
class BelievedPoses {
 public:
  /// Messages of other channels than the mappers' poses are passed over. Throws DecodeError.
  void hear(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  /// By channel, ICP_POSE and FASTSLAM_POSE, of those that were heard; sorted.
  std::map<std::string, BelievedPath> paths() const;

 private:
  std::map<std::string, BelievedPath> heard_;
};

}  // namespace lcmslam

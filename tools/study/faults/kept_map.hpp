#pragma once
// What a map file holds at the end of a run in which processes died, against all that was told on the bus.

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/followed_graph.hpp>

namespace lcmslam {

/// What the dense mapper told of each of its maps, by sender and frame.
using ToldGraphs = std::map<std::pair<std::int64_t, std::string>, FollowedGraph>;

/// The landmarks that FastSLAM told of each of its maps and has not taken away, by sender and frame.
class ToldLandmarks {
 public:
  void apply(const landmarks_t& message);
  const std::map<std::pair<std::int64_t, std::string>, std::set<std::int64_t>>& ids() const { return ids_; }

 private:
  std::map<std::pair<std::int64_t, std::string>, std::set<std::int64_t>> ids_;
};

struct KeptMap {
  int sessions = 0, joined = 0;  ///< of the dense mapper; the first one is joined by itself
  int told = 0, lost = 0;        ///< keyframes of the graphs as they were told last; those the file has not
  int landmarks_told = 0, landmarks_lost = 0;
  /// s of the drive for which the file has no pose of the mapper, in whichever session: the longest.
  double fastslam_gap = 0, icp_gap = 0;
  int placed = 0;    ///< keyframes of joined sessions
  double error = 0;  ///< m, RMSE of where their cameras' robot stands in the map, after the best alignment;
                     ///< NaN without any
};

/// Throws StoreError where the file cannot be read.
KeptMap judge_kept_map(const std::filesystem::path& file, const ToldGraphs& told,
                       const ToldLandmarks& told_landmarks, const Trajectory& truth,
                       const Eigen::Isometry3d& T_robot_camera);

}  // namespace lcmslam

#pragma once
// What a map file holds at the end of a run in which processes died, against all that was told on the bus.

#include <chrono>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/messages/followed_graph.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>

namespace lcmslam {

/// What both mappers told of each of their maps. It follows them as the map server does, but only listens:
/// what it asked for again the map server would hear, too.
class ToldMaps {
 public:
  using Key = std::pair<std::int64_t, std::string>;  ///< sender, frame

  void listen(Inputs& inputs);

  /// Of the dense mapper, and of FastSLAM; without those of strangers, who tell maps and no poses.
  std::map<Key, FollowedGraph> graphs() const;
  std::map<Key, LandmarkMap> landmarks() const;

 private:
  void apply(const landmarks_t& message);

  std::map<Key, FollowedGraph> graphs_;
  std::map<Key, LandmarkMap> landmarks_;
  std::set<Key> dense_mappers_, sparse_mappers_;  // that told poses
};

/// Takes what is still to be heard when nobody speaks any more: a mapper's last graph, which is told whole
/// while it stops, say.
void hear_out(Receiver& receiver, std::chrono::milliseconds silence = std::chrono::milliseconds(200));

/// Keyframes or landmarks, as their mapper told them last.
struct KeptCount {
  int told = 0;
  int lost = 0;      ///< of those: the file has them not
  int unjudged = 0;  ///< the same, but a message was missed that may have taken them away

  void add(bool is_kept, bool was_told_wholly);
};

struct KeptMap {
  int sessions = 0, joined = 0;  ///< of the dense mapper; the first one is joined by itself
  KeptCount keyframes, landmarks;
  /// s of the drive for which the file has no pose of the mapper, in whichever session: the longest.
  double fastslam_gap = 0, icp_gap = 0;
  int placed = 0;    ///< keyframes of joined sessions
  double error = 0;  ///< m, RMSE of where their cameras' robot stands in the map, after the best alignment;
                     ///< NaN without any
};

/// Throws StoreError where the file cannot be read.
KeptMap judge_kept_map(const std::filesystem::path& file, const ToldMaps& told, const Trajectory& truth,
                       const Eigen::Isometry3d& T_robot_camera);

}  // namespace lcmslam

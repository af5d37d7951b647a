#pragma once
// The mappers' maps as the bridge has heard them, told again as changes at another pace: what changed ten
// times since the last telling is told once.

#include <map>
#include <optional>
#include <set>
#include <vector>

#include <lcmslam/graph_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/messages/followed_graph.hpp>
#include <lcmslam/messages/graph_teller.hpp>

namespace lcmslam {

/// FASTSLAM_LANDMARKS of the mapper that spoke last.
class LandmarkTeller {
 public:
  /// Throws DecodeError for a message with wrong values.
  void hear(const landmarks_t& message);
  /// Something was missed: ask the mapper to tell all.
  bool incomplete() const { return map_.incomplete(); }
  /// What changed since it was told last, or all of it; nothing where there is nothing to tell.
  std::optional<landmarks_t> tell(bool whole);
  /// A map's place among others: its mapper and its frame.
  std::int64_t sender() const { return sender_; }
  const std::string& frame() const { return frame_; }

 private:
  std::int64_t sender_ = 0;
  std::string frame_;
  Utime utime_ = 0;
  LandmarkMap map_;
  std::map<std::int64_t, Landmark> told_;
  std::int64_t told_revision_ = 0, messages_ = 0;
};

/// ICP_GRAPH, likewise.
class GraphRelay {
 public:
  void hear(const graph_t& message);
  bool incomplete() const { return heard_ && !graph_.complete(); }
  std::optional<graph_t> tell(bool whole);
  /// Nodes that were told once and that the last telling, whole or not, had no more.
  const std::vector<std::int32_t>& gone() const { return gone_; }
  std::int64_t sender() const { return sender_; }
  const std::string& frame() const { return frame_; }

 private:
  std::int64_t sender_ = 0;
  std::string frame_;
  Utime utime_ = 0;
  FollowedGraph graph_;
  std::set<std::int32_t> told_nodes_;
  std::vector<std::int32_t> gone_;
  GraphTeller teller_;
  bool heard_ = false, changed_ = false, told_ = false;
};

}  // namespace lcmslam

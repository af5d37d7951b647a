#pragma once
// A mapper's graph, put together from what its messages tell of it.

#include <map>
#include <utility>
#include <vector>

#include <lcmslam/graph_t.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

/// Of one sender and one frame.
class FollowedGraph {
 public:
  using Pair = std::pair<std::int32_t, std::int32_t>;  ///< of nodes, as edges name them

  /// Takes over what the message tells. A change that does not build on the message before is taken over as
  /// far as it goes, and one that is older is left out. Throws DecodeError for a pose that is none, lists of
  /// different lengths and more nodes or edges than a graph may have; then nothing has changed.
  void apply(const graph_t& message);

  /// No message was missed since the last whole graph. Otherwise ask the mapper to `resend`.
  bool complete() const { return complete_; }
  /// Keyframes in the map, as the newest message counts them.
  std::int64_t map_revision() const { return map_revision_; }
  /// By id.
  std::vector<KeyframePose> poses() const;
  /// Its id; -1: there is none.
  std::int32_t newest_node() const { return nodes_.empty() ? -1 : nodes_.rbegin()->first; }

  const std::map<std::int32_t, graph_node_t>& nodes() const { return nodes_; }
  const std::multimap<Pair, graph_edge_t>& edges() const { return edges_; }

 private:
  void check(const graph_t& message) const;

  std::map<std::int32_t, graph_node_t> nodes_;
  std::multimap<Pair, graph_edge_t> edges_;
  std::int64_t seq_ = 0, map_revision_ = 0;
  bool heard_ = false, complete_ = true;
};

/// Whether a keyframe was made when the message had been told: that says nothing of it. Over a bridge a graph
/// may come minutes late, and after keyframes that it does not know. `newest_node`: of the graph as the
/// message tells it, -1: it has none.
bool was_made_after(const graph_t& message, std::int32_t newest_node, std::int32_t id, Utime utime);

/// Moves the map's keyframes as the graph has them after this message, which it has applied. Keyframes that
/// it has not, but for those that were made after it was told, go; while messages are missing only those that
/// are named as gone.
void follow(DenseMap& map, const FollowedGraph& graph, const graph_t& message);

}  // namespace lcmslam

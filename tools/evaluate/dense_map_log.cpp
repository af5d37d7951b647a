#include "tools/evaluate/dense_map_log.hpp"

#include <limits>
#include <set>
#include <stdexcept>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/followed_graph.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

/// The map of the mapper that began last, as MapServerNode keeps it.
class NewestMap {
 public:
  /// Throws DecodeError or std::invalid_argument.
  void take(const LogEventView& event) {
    if (event.channel == "ICP_KEYFRAME") {
      const auto message = decode_message<keyframe_t>(event.data, event.size);
      const KeyframeTile tile = from_message(message);
      if (is_newest(message.sender)) map_.add(tile);
    } else if (event.channel == "ICP_GRAPH") {
      const auto message = decode_message<graph_t>(event.data, event.size);
      from_message(message);  // throws before a new mapper's map begins
      if (!is_newest(message.sender)) return;
      graph_.apply(message);
      follow(map_, graph_, message);
    }
  }
  const DenseMap& map() const { return map_; }

 private:
  // A mapper never heard before has begun a map of its own.
  bool is_newest(std::int64_t sender) {
    if (senders_.insert(sender).second) {
      newest_ = sender;
      map_.clear();
      graph_ = {};
    }
    return sender == newest_;
  }

  DenseMap map_;
  FollowedGraph graph_;
  std::set<std::int64_t> senders_;
  std::int64_t newest_ = 0;
};

}  // namespace

LoggedDenseMap dense_map_of(const std::string& log, const Eigen::Isometry3d& T) {
  auto reader = MessageReader::of_all(log);
  NewestMap newest;
  LoggedDenseMap result;
  while (const auto event = reader.next()) {
    try {
      newest.take(*event);
    } catch (const DecodeError&) {
      ++result.refused;
    } catch (const std::invalid_argument&) {
      ++result.refused;
    }
  }
  if (newest.map().keyframes().empty()) throw std::runtime_error(log + ": no ICP_KEYFRAME");

  const Eigen::Vector3f unknown = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  for (const auto& [id, keyframe] : newest.map().keyframes()) {
    const Eigen::Isometry3f T_camera = (T * keyframe.T_world_camera).cast<float>();
    const ColouredCloud& cloud = keyframe.cloud;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const bool known = !cloud.normals.empty() && cloud.normals[i].allFinite();
      result.points.push_back({T_camera * cloud.points[i],
                               known ? Eigen::Vector3f(T_camera.linear() * cloud.normals[i]) : unknown,
                               keyframe.utime});
    }
  }
  return result;
}

}  // namespace lcmslam

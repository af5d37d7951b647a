#include "evaluate/dense_map_log.hpp"

#include <lcmslam/graph_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <limits>
#include <set>
#include <stdexcept>

#include "log/log_reader.hpp"
#include "mapping/dense_map.hpp"
#include "messages/decode.hpp"
#include "messages/geometry_messages.hpp"
#include "messages/map_messages.hpp"

namespace lcmslam {

std::vector<SeenPoint> dense_map_of(const std::string& log, const Eigen::Isometry3d& T) {
  LogReader reader(log);
  DenseMap map;
  graph_t last_graph;
  while (const auto event = reader.next_view()) {
    if (event->channel == "ICP_KEYFRAME")
      map.add(from_message(decode_message<keyframe_t>(event->data, event->size)));
    if (event->channel != "ICP_GRAPH") continue;
    last_graph = decode_message<graph_t>(event->data, event->size);
  }
  std::vector<KeyframePose> poses;
  std::set<std::int32_t> named;
  for (const graph_node_t& node : last_graph.nodes) {
    poses.push_back({node.keyframe, from_message(node.T_map_camera, "T_map_camera")});
    named.insert(node.keyframe);
  }
  map.correct(poses);
  if (map.keyframes().empty()) throw std::runtime_error(log + ": no ICP_KEYFRAME");

  const Eigen::Vector3f unknown = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  std::vector<SeenPoint> points;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (!named.empty() && named.count(id) == 0) continue;  // given up
    const Eigen::Isometry3f T_camera = (T * keyframe.T_world_camera).cast<float>();
    const ColouredCloud& cloud = keyframe.cloud;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const bool known = !cloud.normals.empty() && cloud.normals[i].allFinite();
      points.push_back({T_camera * cloud.points[i],
                        known ? Eigen::Vector3f(T_camera.linear() * cloud.normals[i]) : unknown,
                        keyframe.utime});
    }
  }
  return points;
}

}  // namespace lcmslam

#pragma once
// A map server on a bus of the test's own, and what mappers and users say to it.

#include <gmock/gmock.h>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/status_t.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/test_bus.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam::testing {

class MapServer : public ::testing::Test {
 protected:
  void landmarks(std::int64_t sender, std::int64_t revision, std::int64_t base,
                 const std::vector<std::int64_t>& ids, const std::vector<std::int64_t>& removed = {},
                 const std::string& frame = "map") {
    std::vector<Landmark> upserted;
    upserted.reserve(ids.size());
    for (const std::int64_t id : ids) upserted.push_back(some_landmark(random_, id));
    for (landmarks_t& tile : make_landmark_tiles(1, revision, base, upserted, removed)) {
      tile.seq = seq_++;
      tile.sender = sender;
      tile.frame = frame;
      bus_.deliver("FASTSLAM_LANDMARKS", tile);
    }
  }
  void keyframe(std::int64_t sender, std::int32_t id, std::size_t points, const std::string& frame = "map") {
    DenseKeyframe k = some_keyframe(random_, points);
    k.id = id;
    for (keyframe_t& tile : make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), id + 1)) {
      tile.seq = seq_++;
      tile.sender = sender;
      tile.frame = frame;
      bus_.deliver("ICP_KEYFRAME", tile);
    }
  }
  static graph_t graph_message(std::int64_t sender, const std::vector<std::int32_t>& ids,
                               std::int64_t keyframes) {
    graph_t m{};
    m.utime = 1;
    m.frame = "map";
    m.map_revision = keyframes;
    m.sender = sender;
    for (const std::int32_t id : ids) {
      graph_node_t node;
      node.keyframe = id;
      node.keyframe_utime = 1;
      node.T_map_camera = to_message(Eigen::Isometry3d::Identity());
      m.nodes.push_back(node);
    }
    m.n_nodes = static_cast<int32_t>(ids.size());
    return m;
  }
  void graph(std::int64_t sender, const std::vector<std::int32_t>& ids, std::int64_t keyframes = 1) {
    graph_t m = graph_message(sender, ids, keyframes);
    m.seq = seq_++;
    bus_.deliver("ICP_GRAPH", m);
  }
  /// A mapper's pose at `seconds`, measured against this revision of its map.
  void pose(const std::string& channel, std::int64_t sender, std::int64_t revision, double seconds,
            const std::string& frame = "map") {
    pose_estimate_t m = make_pose_estimate(static_cast<Utime>(1e6 * seconds), Eigen::Isometry3d::Identity(),
                                           Matrix6d::Identity());
    m.seq = seq_++;
    m.sender = sender;
    m.map_revision = revision;
    m.frame = frame;
    bus_.deliver(channel, m);
  }
  map_reply_t request(std::int8_t kind, const std::string& argument = "", const std::string& format = "") {
    map_request_t m;
    m.utime = 5;
    m.seq = seq_++;
    m.sender = 77;
    m.request_id = 1000 + seq_;
    m.kind = kind;
    m.argument = argument;
    m.format = format;
    m.n_numbers = 0;
    const std::size_t before = bus_.count("MAP_REPLY");
    bus_.deliver("MAP_REQUEST", m);
    EXPECT_TRUE(wait_for([&] { return bus_.work(), bus_.count("MAP_REPLY") > before; }));
    const map_reply_t reply = bus_.on<map_reply_t>("MAP_REPLY").back();
    EXPECT_EQ(reply.request_id, m.request_id);
    return reply;
  }
  std::size_t resends(const std::string& process) const {
    std::size_t n = 0;
    for (const command_t& c : bus_.on<command_t>("COMMAND")) n += c.name == "resend" && c.target == process;
    return n;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder() / name); }
  std::filesystem::path own() const { return scratch_.path() / "own"; }
  std::filesystem::path folder() const { return own() / "maps"; }

  Random random_{1};
  ScratchFolder scratch_;
  TestBus bus_;
  MapServerNode& node_ = bus_.add<MapServerNode>(
      ConfigNode::parse("{folder: " + own().string() + ", store: '', export_folders: 3}"));
  std::int64_t seq_ = 0;
};

}  // namespace lcmslam::testing

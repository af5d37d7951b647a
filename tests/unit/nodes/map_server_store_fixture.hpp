#pragma once
// A map server that has a file, and what mappers say to it.

#include <gmock/gmock.h>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/test_bus.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam::testing {

/// One life of a map server.
class StoringServer {
 public:
  static constexpr Utime second = 1'000'000;

  /// `fastslam` and the number after it are the mappers' senders.
  explicit StoringServer(const std::filesystem::path& folder, std::int64_t fastslam = 1)
      : fastslam_(fastslam),
        icp_(fastslam + 1),
        node_(bus_.add<MapServerNode>(ConfigNode::parse("{folder: " + folder.string() + "}"))) {}

  template <class M>
  void send(const std::string& channel, M message, std::int64_t sender) {
    message.seq = seq_++;
    message.sender = sender;
    bus_.deliver(channel, message);
  }
  std::vector<landmarks_t> tiles_of(std::int64_t revision, std::int64_t base,
                                    const std::vector<std::int64_t>& ids,
                                    const std::vector<std::int64_t>& removed = {}) {
    std::vector<Landmark> upserted;
    for (const std::int64_t id : ids) upserted.push_back(some_landmark(random_, id));
    return make_landmark_tiles(1, revision, base, upserted, removed);
  }
  void landmarks(std::int64_t revision, std::int64_t base, const std::vector<std::int64_t>& ids,
                 const std::vector<std::int64_t>& removed = {}) {
    for (const landmarks_t& tile : tiles_of(revision, base, ids, removed))
      send("FASTSLAM_LANDMARKS", tile, fastslam_);
  }
  DenseKeyframe keyframe(std::int32_t id, Utime utime = 0, std::size_t points = 30) {
    DenseKeyframe k = some_keyframe(random_, points);
    k.id = id;
    k.utime = utime;
    for (const keyframe_t& tile : make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), id + 1))
      send("ICP_KEYFRAME", tile, icp_);
    return k;
  }
  /// After a while without anybody, until it is believed.
  void speak(const std::string& channel, std::int64_t sender, const std::string& frame) {
    time_ += 5 * second;
    for (int i = 0; i < 10; ++i) pose(channel, sender, time_ += second / 10, frame);
  }
  /// A mapper of that sender begins a map.
  void landmarks_of(std::int64_t sender, const std::string& frame, const std::vector<std::int64_t>& ids) {
    speak("FASTSLAM_POSE", sender, frame);
    std::vector<Landmark> upserted;
    for (const std::int64_t id : ids) upserted.push_back(some_landmark(random_, id));
    for (landmarks_t& tile : make_landmark_tiles(1, 1, 0, upserted, {})) {
      tile.frame = frame;
      send("FASTSLAM_LANDMARKS", tile, sender);
    }
  }
  void keyframe_of(std::int64_t sender, const std::string& frame, std::size_t points, std::int32_t id = 0) {
    speak("ICP_POSE", sender, frame);
    DenseKeyframe k = some_keyframe(random_, points);
    k.id = id;
    k.utime = time_;
    for (keyframe_t& tile : make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), id + 1)) {
      tile.frame = frame;
      send("ICP_KEYFRAME", tile, sender);
    }
  }
  /// Nodes at x = 1; seq 0 and `whole`, or a change that builds on the message before.
  void graph(std::int64_t seq, bool whole, const std::vector<std::int32_t>& ids,
             const std::vector<std::int32_t>& gone = {}, const std::vector<std::int32_t>& chain = {}) {
    graph_t m{};
    m.utime = 5;
    m.frame = "map";
    m.change = whole ? 0 : 1;
    m.gone = gone;
    m.n_gone = static_cast<std::int32_t>(gone.size());
    for (const std::int32_t id : ids) {
      graph_node_t node;
      node.keyframe = id;
      node.keyframe_utime = 5;
      node.T_map_camera = to_message(Eigen::Isometry3d(Eigen::Translation3d(1, 0, 0)));
      m.nodes.push_back(node);
    }
    m.n_nodes = static_cast<std::int32_t>(ids.size());
    for (std::size_t i = 1; i < chain.size(); ++i) {
      graph_edge_t edge{};
      edge.from_node = chain[i - 1];
      edge.to_node = chain[i];
      edge.kind = graph_edge_t::LOOP;
      edge.T_from_to = to_message(Eigen::Isometry3d::Identity());
      m.edges.push_back(edge);
    }
    m.n_edges = static_cast<std::int32_t>(m.edges.size());
    m.seq = seq;
    m.sender = icp_;
    bus_.deliver("ICP_GRAPH", m);
  }
  void features(Utime utime, int count) {
    FeatureFrame frame = some_features(random_, static_cast<std::size_t>(count));
    frame.utime = utime;
    send("FEATURES", to_message(frame), 3);
  }
  void pose(const std::string& channel, std::int64_t sender, Utime utime, const std::string& frame = "map") {
    pose_estimate_t message =
        make_pose_estimate(utime, Eigen::Isometry3d::Identity(), 4 * Matrix6d::Identity());
    message.frame = frame;
    send(channel, message, sender);
  }
  map_reply_t export_to(const std::string& name) {
    map_request_t m{};
    m.kind = map_request_t::EXPORT;
    m.argument = name;
    m.format = "ply";
    const std::size_t before = bus_.count("MAP_REPLY");
    send("MAP_REQUEST", m, 9);
    EXPECT_TRUE(wait_for([&] { return bus_.work(), bus_.count("MAP_REPLY") > before; }));
    return bus_.on<map_reply_t>("MAP_REPLY").back();
  }
  void finish() { bus_.finish(); }
  MapServerNode& node() { return node_; }
  TestBus& bus() { return bus_; }

 private:
  Random random_{1};
  std::int64_t fastslam_, icp_;
  TestBus bus_;
  MapServerNode& node_;
  std::int64_t seq_ = 0;
  Utime time_ = 0;
};

class MapServerStore : public ::testing::Test {
 protected:
  std::filesystem::path run() const { return scratch_.path() / "run"; }
  std::filesystem::path file() const { return run() / "map.lcmslam"; }
  std::int64_t session(const std::string& mapper) {
    for (const StoredSession& s : MapFile(file()).sessions())
      if (s.mapper == mapper) return s.id;
    return 0;
  }
  std::vector<std::string> faults() { return check_map_file(file()).faults; }

  ScratchFolder scratch_;
};

}  // namespace lcmslam::testing

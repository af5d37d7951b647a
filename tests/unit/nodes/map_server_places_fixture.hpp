#pragma once
// Lives of a map server in the simulated kitchen, whose map is a file that stays.

#include <gmock/gmock.h>
#include <set>

#include <nlohmann/json.hpp>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/seen_kitchen.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam::testing {

using nlohmann::json;

inline constexpr int views_of_room = 6, first_number = 60, frames_between = 5;

/// One life of a map server.
class Life {
 public:
  Life(const std::filesystem::path& folder, const std::string& mode, std::int64_t mapper,
       const std::string& layers = "{make: false, background: false}", bool calibrated = true)
      : node_(bus_.add<MapServerNode>(ConfigNode::parse("{folder: " + folder.string() + ", mode: " + mode +
                                                        ", layers: " + layers + "}"))),
        mapper_(mapper) {
    if (calibrated) calibrate(SimulatedKitchen::instance().calibration());
  }
  /// Keyframes of every frames_between-th frame from there; a mirror image of them is no place of the
  /// kitchen.
  void drive(int from, const Eigen::Isometry3d& T_map_world, bool mirrored = false,
             const std::string& frame = "map") {
    const Utime later = frame == "map" ? 0 : 60'000'000;
    frame_ = frame;
    const RgbdCalibration& calibration = SimulatedKitchen::instance().simulation().calibration();
    for (int k = 0; k < views_of_room; ++k) {
      const SeenView& known = seen_view(from + frames_between * k);
      SeenView view = mirrored ? known.mirrored() : known;
      view.features.utime += later;
      const Eigen::Isometry3d T_map_camera = T_map_world * view.T_world_camera;
      if (later == 0) bus_.deliver("CAMERA", *view.images);
      if (!poses_come_late_) track(view.features.utime, T_map_camera);
      send("FEATURES", to_message(view.features));
      DenseKeyframe keyframe{first_keyframe_ + k, view.features.utime, T_map_camera, view.cloud, 0};
      for (const keyframe_t& tile :
           make_keyframe_tiles(keyframe, calibration.T_robot_camera, keyframe.id + 1))
        send("ICP_KEYFRAME", tile);
      if (poses_come_late_) track(view.features.utime, T_map_camera);
      bus_.work();
    }
    for (int k = 0; k < 2 * views_of_room; ++k) bus_.work();
  }
  void calibrate(const camera_calibration_t& calibration) { bus_.deliver("CAMERA_CALIBRATION", calibration); }
  /// A keyframe comes before the pose of its time.
  void poses_come_late() { poses_come_late_ = true; }
  /// The mapper has made so many keyframes before those that follow.
  void goes_on_from(int keyframes) { first_keyframe_ = keyframes; }
  /// The mapper says where it is.
  void track(Utime utime, const Eigen::Isometry3d& T_map_camera) {
    const RgbdCalibration& calibration = SimulatedKitchen::instance().simulation().calibration();
    pose_estimate_t pose = make_pose_estimate(utime, T_map_camera * calibration.T_robot_camera.inverse(),
                                              Matrix6d::Identity() * 1e-6);
    pose.status = pose_estimate_t::TRACKING;
    send("ICP_POSE", pose);
  }
  json localise() {
    map_request_t request{};
    request.request_id = ++seq_;
    request.kind = map_request_t::QUERY;
    request.argument = R"({"ask": "localise"})";
    bus_.deliver("MAP_REQUEST", request);
    bus_.work();
    const map_reply_t reply = bus_.on<map_reply_t>("MAP_REPLY").back();
    EXPECT_EQ(reply.status, 0) << reply.message;
    return json::parse(reply.data.begin(), reply.data.end());
  }
  /// Features of a frame of which the map has no keyframe.
  void look(int number) { send("FEATURES", to_message(seen_view(number).features)); }
  void give_up(const std::vector<std::int32_t>& keyframes) {
    graph_t graph{};
    graph.change = 1;
    graph.gone = keyframes;
    graph.n_gone = static_cast<std::int32_t>(keyframes.size());
    send("ICP_GRAPH", graph);
  }
  /// The graph says that the keyframes of drive(from, ...) lie there, but for those that it has given up.
  void correct(int from, const Eigen::Isometry3d& T_map_world, const std::set<int>& without = {}) {
    graph_t graph{};
    for (int k = 0; k < views_of_room; ++k) {
      if (without.count(k) > 0) continue;
      const SeenView& view = seen_view(from + frames_between * k);
      graph.nodes.push_back({k, view.features.utime, to_message(T_map_world * view.T_world_camera)});
    }
    graph.n_nodes = static_cast<std::int32_t>(graph.nodes.size());
    graph.map_revision = graph.n_nodes;
    send("ICP_GRAPH", graph);
    bus_.work();
  }
  double value(const std::string& name) { return value_of(node_, name); }
  std::shared_ptr<const LiveMap> derived() const { return node_.shown().live; }
  void work() { bus_.work(); }
  void finish() { bus_.finish(); }

 private:
  template <class M>
  void send(const std::string& channel, M message) {
    message.seq = seq_++;
    message.sender = mapper_;
    if constexpr (!std::is_same_v<M, features_t>) message.frame = frame_;
    bus_.deliver(channel, message);
  }
  TestBus bus_;
  MapServerNode& node_;
  std::int64_t mapper_, seq_ = 0;
  bool poses_come_late_ = false;
  int first_keyframe_ = 0;
  std::string frame_ = "map";
};

class MapServerPlaces : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return scratch_.path() / "map.lcmslam"; }
  void map_once() {
    Life server(scratch_.path(), "map", 3);
    server.drive(first_number, Eigen::Isometry3d::Identity());
    EXPECT_EQ(server.value("sessions_joined"), 0);
    server.finish();
  }
  static Eigen::Isometry3d elsewhere() {
    return Eigen::Translation3d(2, -1, 0) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
           Eigen::Isometry3d::Identity();
  }
  static void expect_near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    EXPECT_LT(distance_between(a, b), 0.02);
    EXPECT_LT(angle_between(a, b), 0.01);
  }
  static Eigen::Isometry3d pose_of(const json& pose) {
    const auto p = pose["position"].get<std::array<double, 3>>();
    const auto q = pose["quaternion"].get<std::array<double, 4>>();
    return make_transform(p.data(), q.data());
  }

  ScratchFolder scratch_;
};

}  // namespace lcmslam::testing

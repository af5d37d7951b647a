#pragma once
// Keeps both mappers' maps, answers MAP_REQUEST, saves at shutdown.

#include <filesystem>
#include <map>

#include <lcmslam/graph_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/node.hpp>
#include "procs/map-server/map_server_settings.hpp"

namespace lcmslam {

/// What one run of a mapper made. A mapper that restarts begins a new map; the old one stays.
template <class Map>
struct Session {
  std::int64_t sender = 0;
  Map map;
};

class MapServerNode : public Node {
 public:
  using Settings = MapServerSettings;
  static Settings read(const ConfigNode& config);

  MapServerNode(const ConfigNode& config, Publisher& publisher);
  MapServerNode(const Settings& settings, Publisher& publisher);

  void connect(Inputs& inputs) override;
  void command(const command_t& command) override;
  void finish() override;
  NodeReport report() const override;

 private:
  using Path = std::vector<Eigen::Vector3d>;

  void on_landmarks(const landmarks_t& message);
  void on_keyframe(const keyframe_t& message);
  void on_graph(const graph_t& message);
  void on_request(const map_request_t& request);
  void follow(const std::string& process, const pose_estimate_t& pose, std::int64_t revision);
  std::vector<std::string> export_maps(const std::filesystem::path& folder, const std::string& formats) const;
  std::string describe() const;

  Publisher& publisher_;
  std::filesystem::path folder_;
  double resolution_;
  std::vector<Session<LandmarkMap>> landmark_maps_;  // the newest last
  std::vector<Session<DenseMap>> dense_maps_;
  Path fastslam_path_, icp_path_;
  struct Progress {
    Utime up_to_date = 0;  // message time at which the map was last complete
    Utime asked = 0;       // message time of the last request
  };
  std::map<std::string, Progress> progress_;             // by mapper
  std::int64_t graph_sender_ = 0, graph_keyframes_ = 0;  // of the newest ICP_GRAPH
  std::int64_t changes_ = 0, saved_changes_ = 0;
  std::int64_t exports_ = 0, resends_ = 0;
};

}  // namespace lcmslam

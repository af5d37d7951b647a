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
#include "procs/map-server/session_table.hpp"

namespace lcmslam {

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
  void on_fastslam_pose(const pose_estimate_t& message);
  void on_icp_pose(const pose_estimate_t& message);
  void add_to_path(Path& path, const pose_estimate_t& message) const;
  void on_request(const map_request_t& request);
  void follow(const std::string& process, const pose_estimate_t& pose, std::int64_t revision);
  std::vector<std::string> export_maps(const std::filesystem::path& folder, const std::string& formats) const;
  std::string describe() const;

  Publisher& publisher_;
  std::filesystem::path folder_;
  double resolution_;
  SessionTable<LandmarkMap> landmark_maps_;
  SessionTable<DenseMap> dense_maps_;
  std::size_t max_path_;
  Path fastslam_path_, icp_path_;
  struct Progress {
    Utime up_to_date = 0;  // message time at which the map was last complete
    Utime asked = 0;       // message time of the last request
  };
  std::map<std::string, Progress> progress_;  // by mapper
  std::int64_t changes_ = 0, saved_changes_ = 0;
  std::int64_t exports_ = 0, resends_ = 0;
};

}  // namespace lcmslam

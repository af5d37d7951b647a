#pragma once
// Keeps both mappers' maps, answers MAP_REQUEST, saves at shutdown.

#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/node.hpp>
#include "procs/map-server/keyframe_features.hpp"
#include "procs/map-server/landmark_sessions.hpp"
#include "procs/map-server/layer_feed.hpp"
#include "procs/map-server/map_files.hpp"
#include "procs/map-server/map_recorder.hpp"
#include "procs/map-server/map_server_settings.hpp"
#include "procs/map-server/question_desk.hpp"
#include "procs/map-server/reply_tiles.hpp"
#include "procs/map-server/session_places.hpp"
#include "procs/map-server/session_table.hpp"

namespace lcmslam {

class MapServerNode : public Node {
 public:
  using Settings = MapServerSettings;
  static Settings read(const ConfigNode& config);

  MapServerNode(const ConfigNode& config, Publisher& publisher);
  MapServerNode(const Settings& settings, Publisher& publisher);

  void connect(Inputs& inputs) override;
  std::optional<Duration> work() override;
  void command(const command_t& command) override;
  void overhear(const command_t& command) override { keep_what_is_reset(command); }
  void finish() override;
  NodeReport report() const override;

  using Path = MapsToSave::Path;

  /// What is there to be looked at now, until the next call of anything.
  struct Shown {
    SessionKey map;                             ///< the current dense map; the landmarks where there is none
    const DenseMap* dense = nullptr;            ///< null: none yet
    const FollowedGraph* graph = nullptr;       ///< of it
    const LandmarkMap* landmarks = nullptr;     ///< null: none yet
    const pose_estimate_t* icp_pose = nullptr;  ///< the newest; null: none yet
    const pose_estimate_t* fastslam_pose = nullptr;
    const Path *icp_path = nullptr, *fastslam_path = nullptr;
    std::shared_ptr<const LiveMap> live;  ///< null: no frame was seen yet
  };
  Shown shown() const;
  /// A mapper's map, of this run or kept in the file.
  struct ToldSession {
    std::string name, mapper;
    Utime begin = 0, end = 0;  ///< us, of the first and the last keyframe; 0: not known
    bool is_current = false, is_kept = false;
    std::size_t keyframes = 0, landmarks = 0;
    /// What says where it lies in the map, "" of the map's first; nothing: it lies apart.
    std::optional<std::string> joined = {};
  };
  std::vector<ToldSession> told_sessions() const;
  /// A message of CAMERA that came lately; null: none of that time did.
  std::shared_ptr<const EncodedFrame> image_at(Utime colour_time) const;
  /// Null: none came.
  std::shared_ptr<const EncodedFrame> newest_image() const;
  /// What a question looks at. Throws std::runtime_error in words for who asked.
  AskedMap asked_map(const Question& question) const;
  /// How an export ended; `error` is empty where all was written.
  using Exported = std::function<void(const std::vector<std::string>& files, const std::string& error)>;
  /// As MAP_REQUEST's EXPORT does, beside the messages: work() calls `done`. Throws std::runtime_error in
  /// words for who asked where it is not begun.
  void export_maps(const map_request_t& request, Exported done);

 private:
  void on_landmarks(const landmarks_t& message);
  void keep_beside(const landmarks_t& message, LandmarkMap& map, LandmarkMap before);
  void on_keyframe(const keyframe_t& message);
  void on_features(const features_t& message);
  void remember(const KeyframeFeatures::Found& found);
  void begin_layers(const SessionKey& key);
  void begin_places(const SessionKey& key);
  void correct_places(const graph_t& message, const SessionTable<DenseMap>::Session& session,
                      bool takes_most);
  void hear_fastslam(const SessionKey& key);
  void note_joined();
  template <class Map>
  void note_joined(const std::string& mapper, const SessionPlaces::Joined& joined,
                   SessionTable<Map>& sessions);
  template <class Map>
  std::optional<std::string> evidence(const std::string& mapper, const SessionTable<Map>& sessions,
                                      std::size_t index) const;
  void show_late();
  template <class Map>
  void retire(const std::string& mapper, SessionTable<Map>& sessions);
  void derive_from(const SessionKey& key, const DenseKeyframe& keyframe);
  void on_graph(const graph_t& message);
  void on_fastslam_pose(const pose_estimate_t& message);
  void on_icp_pose(const pose_estimate_t& message);
  void show_frame(const pose_estimate_t& message);
  void add_to_path(Path& path, const pose_estimate_t& message) const;
  void on_camera(const images_t& message);
  void on_calibration(const camera_calibration_t& message);
  bool is_current(const SessionKey& key) const;
  void on_request(const map_request_t& request);
  void refuse_request(map_reply_t& reply, const std::string& why);
  void ask(const map_request_t& request);
  ColouredCloud points_in(const Region& region) const;
  void follow(const std::string& process, const pose_estimate_t& pose, std::int64_t revision);
  HeldFolder export_folder(const std::string& name);
  void answer_export(const map_request_t& request);
  void begin_export();
  MapsToSave maps_to_save(bool with_kept) const;
  void save_beside();
  void keep_what_is_reset(const command_t& command);
  void note_saving(bool wait);
  void note_store();
  void begin_file_beside();
  void record_all();
  void read_again(std::chrono::milliseconds patience);
  void go_on_with_stored();
  std::string damage() const;
  std::string describe() const;

  Publisher& publisher_;
  std::filesystem::path folder_;
  double resolution_;
  bool localises_;
  SessionTable<LandmarkMap> landmark_maps_;
  SessionTable<DenseMap> dense_maps_;
  std::size_t max_path_;
  Path fastslam_path_, icp_path_;
  struct Progress {
    std::int64_t wanted = 0;  // revision that a pose named
    Utime since = 0;          // message time of that pose
    Utime asked = 0;          // message time of the last request
    Utime pause = 0;          // us until the next one
  };
  std::map<std::string, Progress> progress_;  // by mapper
  std::int64_t changes_ = 0, saved_changes_ = 0;
  std::int64_t drawn_changes_ = 0;  // whose pictures were written
  std::int64_t resends_ = 0;

  double snapshot_period_;  // s
  std::chrono::duration<double> saving_took_{};
  std::chrono::steady_clock::time_point last_snapshot_ = std::chrono::steady_clock::now();
  std::size_t most_export_folders_;
  std::set<std::string> export_folders_;  // that requests named
  std::int64_t saved_ = 0, requests_refused_ = 0;
  std::string failure_;  // of the last saving; empty: it went well
  struct Export {
    map_request_t request;
    HeldFolder folder;
    Exported done;
  };
  std::deque<Export> exports_;  // that wait
  struct Reset {
    MapsToSave maps;  // as they were
    std::filesystem::path folder;
  };
  std::deque<Reset> resets_;  // likewise
  int reset_number_ = 0;
  std::optional<Export> exporting_;  // what saver_ does is this
  BackgroundSaver saver_;
  std::string configuration_;            // as the file tells it
  std::optional<MapRecorder> recorder_;  // none: no file was asked for
  std::string overwritten_;              // what became of the file before; empty: nothing
  std::string store_failure_, damage_;   // as they were last told; empty: none
  std::int64_t restored_ = 0;            // see StoreWriter::State, likewise
  std::chrono::steady_clock::time_point next_reading_{};
  std::optional<LayerFeed> layers_;  // none: nothing is derived
  std::set<std::int32_t> late_;      // keyframes of the current map that are to be shown to the layers
  KeyframeFeatures keyframe_features_;
  std::unique_ptr<SessionPlaces> places_;              // null: nothing is remembered
  std::unique_ptr<LandmarkSessions> landmark_places_;  // as places_
  std::map<std::string, std::int64_t> joined_;         // sessions whose place was found, by mapper
  camera_calibration_t calibration_message_;
  std::shared_ptr<const StoredCalibration> stored_calibration_;  // the same
  const StampJudge* stamps_ = nullptr;
  std::optional<Eigen::Isometry3d> T_map_robot_;             // of the newest ICP_POSE
  std::optional<pose_estimate_t> icp_pose_, fastslam_pose_;  // the newest
  std::shared_ptr<const EncodedFrame> picture_;              // that came without depth
  QuestionDesk desk_;
  ReplyTiles replies_;
  std::int64_t answered_ = 0;
  bool finished_ = false;
};

}  // namespace lcmslam

#pragma once
// Free and occupied space and distances while frames keep coming: one thread shows frames, any thread asks.
//
// Distances follow the frames while somebody asks for them. When nobody has for a while they rest, and the
// next question brings them up to date.
//
// When the graph bends, space is carved anew beside the frames, from the keyframes' depth, and takes the old
// one's place when it is done. Frames between keyframes that came meanwhile are seen again soon enough.

#include <atomic>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <utility>

#include <lcmslam/live_map/live_map_settings.hpp>
#include <lcmslam/live_map/moved_keyframes.hpp>
#include <lcmslam/map_layers/carved_keyframes.hpp>
#include <lcmslam/map_layers/near_distances.hpp>
#include <lcmslam/map_query/newest_frame.hpp>

namespace lcmslam {

class LiveSpace {
 public:
  /// Throws std::invalid_argument that names the setting.
  explicit LiveSpace(const LiveMapSettings& settings);

  // One thread.

  /// Where a keyframe's depth camera stands.
  struct Place {
    int keyframe;
    Eigen::Isometry3d T_map_depth;
  };
  /// `depth` as DepthCarver takes it, of the camera's size. T_map_depth must be finite. A frame between
  /// keyframes hangs on one of them, with which it moves.
  void show(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_depth,
            const std::optional<Place>& hangs_on = std::nullopt);
  /// A frame whose place is not sure enough to change the map: it shows what stands in the way now, and no
  /// more.
  void glance(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_depth);
  /// A frame of before: what it sees is carved, but it is not what the newest frame shows, nor where the
  /// camera is.
  void show_before(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_depth);
  /// Keeps what was shown last for corrections.
  void keep(int keyframe, const cv::Mat& depth, const CameraModel& camera,
            const Eigen::Isometry3d& T_map_depth);
  /// Keyframes stand elsewhere: T_map_depth by keyframe.
  void correct(const std::map<int, Eigen::Isometry3d>& T_map_depth);
  /// These make room: the next time that space is carved anew it is without them.
  void forget(const std::vector<int>& keyframes);
  /// Corrections have left something, or it is being made.
  bool is_behind() const { return carving_.valid() || moved_.moved(); }
  /// No frame comes for now, for which that would wait.
  void catch_up();
  /// Waits for what is made beside the frames.
  void settle();

  // Any thread.

  /// What a question sees; nothing changes while it looks, and frames wait for it.
  struct View {
    const OccupancyGrid& occupied;
    const NearDistances& distances;
    const DistanceField& newest;  ///< of the newest frame alone
  };
  template <class Ask>
  auto ask(const Ask& question) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    bring_up_to_date();
    return question(View{grid_, near_, newest_.field()});
  }
  /// The same for questions that need no distances: `question(const OccupancyGrid&)`.
  template <class Ask>
  auto ask_occupied(const Ask& question) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return question(std::as_const(grid_));
  }
  /// Distances in a box, m, that View's do not cover: made for the purpose, frames do not wait meanwhile.
  DistanceField distances_in(const Eigen::AlignedBox3d& box) const;
  /// For questions that take their time.
  OccupancyGrid copy() const {
    return ask_occupied([](const OccupancyGrid& occupied) { return occupied.copy(); });
  }
  std::size_t memory_bytes() const;

 private:
  struct Carved {
    CarvedKeyframes keyframes;
    OccupancyGrid grid;
  };
  void begin_frame();
  void hang(const std::vector<OccupancyChange>& hits, const Place& on);
  void carve_anew();
  void take_over(bool wait);
  void measure() const;
  void follow(const Eigen::Vector3d& place);
  void bring_up_to_date() const;

  double cell_size_;  // m
  bool background_;
  int distance_every_, distance_rest_;
  DistanceSettings distance_;
  DepthCarver carver_;
  CarvedKeyframes keyframes_;
  MovedKeyframes moved_;
  std::future<Carved> carving_;
  std::vector<std::function<void(Carved&)>> meanwhile_;  // what came while it went on
  std::atomic<std::size_t> kept_bytes_{0};
  mutable std::atomic<std::size_t> space_bytes_{0};

  mutable std::mutex mutex_;  // guards what follows
  mutable OccupancyGrid grid_;
  mutable NearDistances near_;
  mutable NewestFrame newest_;
  mutable std::optional<std::vector<OccupancyChange>> hits_;  // of the newest frame, until somebody asks
  mutable int unmeasured_ = 0;                                // frames that distances have not followed yet
  // Only a question sets it, only a frame takes it back: while it is set, distances are the frames' alone.
  mutable bool awake_ = false;
  mutable int unasked_ = 0;                          // frames since the last question
  Eigen::Vector3d place_ = Eigen::Vector3d::Zero();  // of the camera, in the map
};

}  // namespace lcmslam

#pragma once
// The planes of a map while keyframes keep coming: one thread adds keyframes, any thread asks.
//
// Planes that were put together cannot be taken apart: when the graph bends, they are put together anew from
// what was found in the keyframes' depth images, beside the frames.

#include <future>
#include <map>
#include <memory>
#include <mutex>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/live_map/live_map_settings.hpp>
#include <lcmslam/live_map/moved_keyframes.hpp>
#include <lcmslam/planes/plane_map.hpp>

namespace lcmslam {

class LivePlanes {
 public:
  /// Throws std::invalid_argument that names the setting.
  LivePlanes(const RgbdCalibration& calibration, const LiveMapSettings& settings);

  // One thread.

  /// Keyframes that follow are another camera's. Throws as the constructor.
  void look_through(const RgbdCalibration& calibration);
  /// `depth` CV_16UC1 mm, filtered, of the calibration's size.
  void keep(int keyframe, const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth);
  /// A frame that is no keyframe came: time for what a correction left.
  void frame();
  /// Keyframes stand elsewhere: T_map_depth by keyframe.
  void correct(const std::map<int, Eigen::Isometry3d>& T_map_depth);
  /// These make room: the next time that planes are put together anew it is without them.
  void forget(const std::vector<int>& keyframes);
  /// Corrections have left something, or it is being made.
  bool is_behind() const { return making_.valid() || moved_.moved(); }
  /// No frame comes for now, for which that would wait.
  void catch_up();
  /// Waits for what is made beside the frames.
  void settle();

  // Any thread.

  std::vector<PlanePatch> patches() const;
  std::size_t memory_bytes() const;

 private:
  struct Keyframe {
    std::shared_ptr<const FramePlaneFinder> finder;  // that found them
    std::vector<FramePlane> planes;
    EncodedImage labels;  // some kB
    Eigen::Isometry3d T_map_depth;
  };
  using Keyframes = std::map<int, Keyframe>;
  static void insert(const Keyframe& keyframe, PlaneMap& map);
  void drop(Keyframes::iterator keyframe);
  void put_together_anew();
  void take_over(bool wait);

  LiveMapSettings settings_;
  std::shared_ptr<FramePlaneFinder> finder_;  // of the newest keyframe's camera
  Keyframes keyframes_;
  MovedKeyframes moved_;
  std::future<PlaneMap> making_;
  std::vector<int> meanwhile_;  // keyframes that came while it went on

  mutable std::mutex mutex_;  // guards what follows
  PlaneMap map_;
  std::size_t kept_bytes_ = 0;
};

}  // namespace lcmslam

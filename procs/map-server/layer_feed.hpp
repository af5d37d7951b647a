#pragma once
// Finds where the dense mapper says that each of the camera's images was taken, and shows them to the derived
// maps in a thread of its own: what is derived never delays what arrives.

#include <deque>
#include <functional>
#include <optional>

#include <lcmslam/map_store/file/stored_map.hpp>
#include <lcmslam/messages/followed_graph.hpp>
#include <lcmslam/messages/stored_calibration.hpp>
#include "procs/map-server/layer_settings.hpp"
#include "procs/map-server/layer_worker.hpp"

namespace lcmslam {

class LayerFeed {
 public:
  /// Throws std::invalid_argument that names the setting.
  explicit LayerFeed(const LayerSettings& settings);

  /// The camera whose frames follow. What is there already stays.
  void calibrate(const RgbdCalibration& calibration);
  const std::optional<RgbdCalibration>& calibration() const { return calibration_; }
  /// Another map, in another frame: the layers begin anew.
  void begin_map();

  using KeptImages = std::function<std::optional<StoredImages>()>;

  // Before calibrate() nothing happens.
  void camera(EncodedFrame frame);
  /// The robot at `utime`, measured against the map.
  void pose(Utime utime, const Eigen::Isometry3d& T_map_robot);
  /// The robot at `utime`, where measurements say that poorly: its frame shows what stands in the way, and
  /// the maps learn nothing of it.
  void poor_pose(Utime utime, const Eigen::Isometry3d& T_map_robot);
  /// Before calibrate(), and while many others wait, a keyframe is better shown later; not where its images
  /// are gone by then.
  bool has_time_for(const DenseKeyframe& keyframe) const;
  /// Gives what is to be kept of it: its images. Where those have not come, or are gone, it is shown with
  /// what `kept` gives, or else its cloud; so, too, where nobody knows by which calibration that was taken.
  std::optional<StoredImages> keyframe(const DenseKeyframe& keyframe, const KeptImages& kept = {});
  /// A keyframe of another map, which no graph moves: from its images, or its cloud where there are none of
  /// which the calibration is known.
  void adopt(int id, const Eigen::Isometry3d& T_map_camera, const std::optional<StoredImages>& images,
             ColouredCloud cloud);
  /// Where adopted ones lie, T_map_camera by id.
  void move_adopted(std::map<int, Eigen::Isometry3d> T_map_camera) {
    worker_.move_adopted(std::move(T_map_camera));
  }
  /// After the graph has moved the map. What it has given up moves with its neighbours, once it is known
  /// whole.
  void correct(const DenseMap& map, const FollowedGraph& graph);
  /// Waits until all is done that was handed in, at most so long.
  void settle(std::chrono::steady_clock::duration longest) { worker_.settle(longest); }

  /// Null before calibrate().
  std::shared_ptr<const LiveMap> map() const { return worker_.map(); }
  /// A frame of the last seconds; null: none of that colour image.
  LayerWorker::Frame image_at(Utime colour_time) const;
  LayerWorker::Frame newest_image() const { return frames_.empty() ? nullptr : frames_.back(); }
  LayerWorker::State state() const { return worker_.state(); }

 private:
  std::optional<Eigen::Isometry3d> motion(Utime from, Utime to) const;
  LayerWorker::Frame frame_of(const DenseKeyframe& keyframe) const;
  LayerWorker::Frame frame_at(Utime depth_time) const;
  FramePose pose_at_colour(const EncodedFrame& frame, const Eigen::Isometry3d& T_map_camera) const;

  // us between two frames that are shown, and between two by which the surface grows; 0: keyframes alone.
  Utime period_, surface_period_;
  LayerWorker worker_;
  std::optional<RgbdCalibration> calibration_;
  KnownCalibrations known_;
  LayerWorker::Calibration newest_;        // calibration_, as images read
  std::deque<LayerWorker::Frame> frames_;  // the last seconds'
  std::size_t frame_bytes_ = 0;
  std::deque<std::pair<Utime, Eigen::Isometry3d>> poses_;  // of the robot, the last seconds'
  Utime next_shown_ = 0, next_fused_ = 0;
};

}  // namespace lcmslam

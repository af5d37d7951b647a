#pragma once
// The mapper's keyframes: coloured clouds and where they were seen from. Their points are bounded, those of
// keyframes that the graph has thinned out join their neighbours', and the store knows whose cloud has
// changed since it was published.

#include <deque>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/dense_mapper/dense_mapper_settings.hpp>

namespace lcmslam {

class KeyframeStore {
 public:
  struct Keyframe {
    int node = 0;  ///< index in the graph
    Utime utime = 0;
    Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
    ColouredCloud cloud;      ///< camera frame, with normals
    double voxel = 0;         ///< m, of that cloud; 0: points as they came
    std::size_t changed = 0;  ///< points that went or came since the cloud was published
    bool to_sweep = false;    ///< may have points where surfaces have gone; whoever it joins has them then
  };

  /// Reads the settings keyframe_*.
  explicit KeyframeStore(const DenseMapperSettings& settings);

  /// In order of time.
  const std::vector<Keyframe>& all() const { return keyframes_; }
  /// How many there have been.
  std::int64_t made() const { return made_; }
  std::size_t memory_bytes() const;

  /// Whether a new keyframe should be there: far from every one, or, with half the way gone, where little is
  /// known (`overlap` of the frame with the map).
  bool is_due(const Eigen::Isometry3d& T_world_camera, double overlap) const;
  /// Whether two cameras see as different things as two keyframes do; with `share` of the way that takes.
  bool is_far(const Eigen::Isometry3d& T_world_camera, const Eigen::Isometry3d& T_world_other,
              double share = 1) const;

  /// `cloud` in the camera frame. Where all points together become too many, the clouds farthest away are
  /// thinned.
  void add(int node, Utime utime, const Eigen::Isometry3d& T_world_camera, const ColouredCloud& cloud);

  /// For a map that grows by what each frame adds: a keyframe without points, and points of the world that
  /// join the newest one. They stay as they are. They count as changed when the next keyframe begins, so that
  /// a keyframe is not published anew with every frame.
  void begin(int node, Utime utime, const Eigen::Isometry3d& T_world_camera);
  void grow(const ColouredCloud& cloud);

  /// Surfaces have gone: all keyframes are to be swept.
  void begin_sweep();
  /// The i-th keyframe has been swept, and these points (true) are no longer there; none: it has nothing
  /// there.
  void swept(std::size_t i, const std::vector<bool>& gone = {});

  /// Each keyframe moves with its node.
  void deform(const KeyframeGraph::Correction& correction);
  /// Keyframes whose nodes went retire: one by one, their clouds join those of their successors.
  void thin(const KeyframeGraph::Thinned& thinned);
  bool merging() const { return !retired_.empty(); }
  void merge_next();

  /// Indices of the keyframes whose clouds have changed since they were last published: those that changed
  /// notably, or all. They count as published then.
  std::vector<std::size_t> take_changed(bool all);

 private:
  void settle();
  void bound(const Eigen::Isometry3d& T_world_camera);
  Keyframe& successor_of(const Keyframe& retired);

  DenseMapperSettings settings_;
  std::vector<Keyframe> keyframes_;
  std::deque<Keyframe> retired_;
  std::int64_t made_ = 0;
  std::size_t growing_ = 0;  // points of the newest keyframe that do not count as changed yet
};

}  // namespace lcmslam

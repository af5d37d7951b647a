#pragma once
// What a correction of the graph needs to carve the map anew: a small depth image of each keyframe.
//
// Log-odds cannot be moved once they are summed, and submaps of log-odds would be kept several times over
// where views overlap and would still have to agree on what moved meanwhile. A keyframe's depth is 40 kB, is
// moved by its pose alone, and carving it anew takes some two milliseconds.
// What frames between keyframes saw is not lost with them. Surfaces that a keyframe did not see are kept with
// the one that the frame hangs on, cell by cell, and move with it. And before a keyframe is carved anew it is
// asked of the grid that was, with the pose it had there, whether its surfaces still stand: what was seen
// through since is carved as free space only.

#include <map>
#include <optional>
#include <vector>

#include <lcmslam/map_layers/depth_carver.hpp>

namespace lcmslam {

class CarvedKeyframes {
 public:
  /// Reads max_keyframes. Throws std::invalid_argument that names the setting.
  explicit CarvedKeyframes(const OccupancySettings& settings);

  /// `depth` as DepthCarver::carve() takes it; kept at 107 to 239 columns where it has more. Another of the
  /// same id replaces it.
  void add(int id, const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_camera);
  /// A frame hangs on keyframe `id`, which stands at T_map_camera by now, and hit these cells of `carved`.
  /// Does nothing where there is no such keyframe.
  void follow(int id, const Eigen::Isometry3d& T_map_camera, const std::vector<OccupancyChange>& hits,
              const OccupancyGrid& carved);
  void forget(int id);  ///< does nothing where there is none

  /// Keyframes carved in the order of their ids at their new poses, T_map_camera by id; those without one
  /// stay. `carved`: the grid that holds them at their old poses. The new poses are the old ones from now on.
  /// `place`: of the robot, m; what is nearest to it stays where a grid is full. Work for a thread beside the
  /// frames, on copies of both.
  OccupancyGrid carve_anew(const std::map<int, Eigen::Isometry3d>& corrected, const OccupancyGrid& carved,
                           const Eigen::Vector3f& place);

  std::size_t size() const { return keyframes_.size(); }
  /// Cells that are kept beside the images, because only frames saw them.
  std::size_t cells_of_frames() const;
  /// Keyframes that gave way to newer ones since the beginning.
  std::size_t forgotten() const { return forgotten_; }
  std::size_t memory_bytes() const;

 private:
  struct Keyframe {
    cv::Mat depth;  // CV_16SC1 mm; below zero: seen through since
    CameraModel camera;
    cv::Mat rays;                              // ray_table(camera), of all keyframes by this camera
    Eigen::Isometry3d T_map_camera;            // where it is carved
    std::vector<Eigen::Vector3f> also_seen{};  // by frames: middles of cells, m in its camera's frame
    Eigen::Vector3f point(int u, int v, int millimetres_deep) const;
    void mark_gone(const OccupancyGrid& carved);
    void drop_gone(const Eigen::Isometry3d& T, const OccupancyGrid& carved);
  };
  /// The keyframe that frames hang on, and the cells of the map that it has seen.
  struct Followed {
    int id = 0;
    Eigen::Isometry3d T_map_camera;
    VoxelIndex cells{};
    std::size_t count = 0;  // of those cells
    std::size_t most = 0;   // of also_seen, before what is gone is dropped
  };
  void look_at(int id, const Eigen::Isometry3d& T_map_camera);

  OccupancySettings settings_;
  std::map<int, Keyframe> keyframes_;
  std::optional<Followed> followed_;
  std::size_t forgotten_ = 0;
};

}  // namespace lcmslam

#pragma once
// A drive through both mappers, as batch runs them, and how good what they made is.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <lcmslam/associations_t.hpp>
#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/features/landmark.hpp>
#include "tools/study/believed_poses.hpp"
#include "tools/study/report/drive.hpp"

namespace lcmslam {

struct MapperChoice {
  std::string preset = "modern";  ///< or thesis: config/replay.yaml, config/thesis.yaml
  std::vector<std::string> set;   ///< overrides, section.key=value
  bool fastslam = true, icp = true;
  int seed = 1;  ///< of particles and of noise added to the odometry
  std::string odometry = "wheels";
};

struct MappingRun {
  Trajectory odometry, fastslam, smoothed;
  Trajectory icp, icp_final;  ///< as it was said, and after the last correction of the graph
  BelievedPath fastslam_believed, icp_believed;  ///< of the first map
  std::vector<Landmark> landmarks;               ///< fastslam's at the end, in its map
  std::vector<int> landmark_counts;              ///< given out so far, by frame
  ColouredCloud cloud;                           ///< icp's at the end, in its map
  std::vector<associations_t> associations;
  std::vector<double> iterations, residuals;  ///< of icp's registrations: how many; RMS at their end, m
  int fastslam_lost = 0, icp_lost = 0;        ///< poses of that status, of all maps
  /// New maps that were begun. Where there is one the mapper has no path and no map above: the newest is of a
  /// part of the drive, and its error would be taken for that of all.
  int fastslam_restarts = 0, icp_restarts = 0;
  std::map<std::string, double> cpu_seconds;      ///< by process; differs from run to run
  double icp_megabytes = 0;                       ///< of its map, as icp says itself; NaN: it does not
  std::map<std::string, std::int64_t> map_bytes;  ///< fastslam, icp: that they published of their maps
};

MappingRun map_drive(const Drive& drive, const MapperChoice& choice);

/// Runs of one drive or several, two at a time; `count` times f(i), in any order.
void run_side_by_side(std::size_t count, const std::function<void(std::size_t)>& f);

/// Of positions after the best rigid fit, m; NaN where less than half of the drive has a pose.
double path_error(const Trajectory& truth, const Trajectory& path);
/// T_world_map by all poses: the mean rotation and then the mean position agree. (A fit of positions alone,
/// as above, leaves a straight path's roll open, and with it the map.) Identity without a path.
Eigen::Isometry3d fit_to_truth(const Trajectory& truth, const Trajectory& path);

/// Distances of a map's points from the scene's true surfaces, m, ascending, the map laid on the truth by the
/// best fit of its path. At most so many points, evenly taken.
std::vector<double> surface_distances(const Drive& drive, const Eigen::Isometry3d& T_world_map,
                                      const std::vector<Eigen::Vector3d>& points, std::size_t most = 20000);
std::vector<Eigen::Vector3d> places_of(const std::vector<Landmark>& landmarks);
std::vector<Eigen::Vector3d> places_of(const ColouredCloud& cloud);

/// Surface that the depth camera saw from the true poses, in cells of 10 cm.
struct SeenSurface {
  std::vector<Eigen::Vector3d> cells;  ///< m, world: their mean points
  static constexpr double side = 0.1;
};
SeenSurface seen_surface(const Drive& drive);
/// Share of the cells' points that have a map point within 10 cm.
double coverage(const SeenSurface& seen, const Eigen::Isometry3d& T_world_map,
                const std::vector<Eigen::Vector3d>& points);

}  // namespace lcmslam

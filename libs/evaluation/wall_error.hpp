#pragma once
// Does a map show each wall once? Where a robot comes back with an error, the wall that it sees again stands
// beside its first picture. Measured in patches of the true walls: how far the points of the last visit lie
// from those of the first one, across the wall, and how thick the wall is in the map.

#include <vector>

#include <lcmslam/evaluation/surface_error.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// A true wall and the side that it is seen from.
struct WallTriangle {
  Triangle corners;        ///< m
  Eigen::Vector3f normal;  ///< unit, towards the room
};

struct SeenPoint {
  Eigen::Vector3f point;   ///< m, the walls' frame
  Eigen::Vector3f normal;  ///< unit; NaN where unknown
  Utime utime = 0;         ///< when it was seen
};

struct WallErrorSettings {
  double patch = 0.25;      ///< m, side
  double reach = 0.15;      ///< m from the wall: other points are none of it, at most 0.3
  double away = 20;         ///< s without a point of the patch end a visit
  int min_points = 20;      ///< of a visit; patches with fewer are not judged
  double min_cosine = 0.8;  ///< between the point's and the wall's normal
};

/// NaN where there is no patch to tell it by. A wall that stands farther off than the reach is in no patch
/// and has no offset: only `beyond` shows it.
struct WallError {
  std::size_t points = 0;                          ///< that are finite
  double beyond = 0;                               ///< share of the points that have no surface in reach
  int patches = 0;                                 ///< with enough points
  double thickness_median = 0, thickness_p95 = 0;  ///< m, of a patch: from 2.5 to 97.5 % of its points
  int revisited = 0;                               ///< patches with at least two visits
  double offset_median = 0, offset_p95 = 0,
         offset_max = 0;  ///< m: between the medians of first and last visit
};

/// Points nearer to one of `others` than to the wall are not counted.
WallError wall_error(const std::vector<SeenPoint>& points, const std::vector<WallTriangle>& walls,
                     const TriangleSurface& others, const WallErrorSettings& settings = {});

}  // namespace lcmslam

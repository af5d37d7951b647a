#pragma once
// Maps as the page draws them. Every function is plain: the same map gives the same items, and who keeps the
// items sees by their bytes what has changed.

#include <vector>

#include <lcmslam/features/landmark.hpp>
#include <lcmslam/live_map/live_map.hpp>
#include <lcmslam/live_page/page_item.hpp>
#include <lcmslam/map_store/dense_map.hpp>

namespace lcmslam {

/// A keyframe's cloud, coarse to fine: the points of a level are those that share no cell with one before, so
/// each prefix of levels is an even sample. Nine bytes a point.
std::vector<PageItem> points_items(const DenseKeyframe& keyframe);
constexpr int point_levels = 3;

/// A cube of the surface: nine bytes a vertex; without any, when it has become empty.
PageItem mesh_item(const MeshCube& cube, const Mesh& mesh);

/// In cubes of 4 m; at most `most` landmarks, those that were seen most often.
std::vector<PageItem> landmark_items(std::vector<Landmark> landmarks, std::size_t most = 30'000);

/// Poses in their order, in pieces of 512; key "NAME/0", "NAME/1", ...
std::vector<PageItem> path_items(const std::string& name, const std::vector<Eigen::Vector3d>& path,
                                 std::size_t first = 0);

struct PageEdge {
  std::int32_t from = 0, to = 0;  ///< keyframes
  int kind = 0;                   ///< 0 odometry, 1 registration, 2 loop
  float error = 0;                ///< Mahalanobis distance after optimisation
};
PageItem graph_item(const std::vector<KeyframePose>& nodes, const std::vector<PageEdge>& edges);

PageItem grid_item(const NavigationGrid& grid);
PageItem planes_item(const std::vector<PlanePatch>& planes);
/// `vertices` of the surface, m, map.
PageItem objects_item(const std::vector<PlanePatch>& planes, const std::vector<Eigen::Vector3f>& vertices,
                      const ObjectSettings& settings);

}  // namespace lcmslam

#include <lcmslam/live_page/shown_layers.hpp>

#include <lcmslam/live_page/map_items.hpp>
#include <lcmslam/live_page/show_on_board.hpp>

namespace lcmslam {

void ShownLayers::show(const std::shared_ptr<const LiveMap>& map,
                       const std::optional<Eigen::Isometry3d>& T_map_robot) {
  if (map != map_) {
    for (const char* channel : {"mesh", "grid", "planes", "objects"}) board_.remove(channel);
    map_ = map;
    changed_ = 0;
    version_ = whole_version_ = -1;
    looks_ = 0;
  }
  if (!map) return;
  const std::int64_t version = map->version();
  if (version != version_) show_mesh();
  version_ = version;
  // What is looked at whole, and seldom changes much, not each time.
  if (looks_++ % 3 != 0 || version == whole_version_) return;
  whole_version_ = version;
  const std::vector<PlanePatch> planes = map->planes();
  show_on(board_, planes_item(planes));
  show_on(board_, objects_item(planes, map->mesh().vertices, map->settings().objects));
  if (!T_map_robot) return;
  const OccupancyGrid space = map->space().copy();
  show_on(board_, grid_item(make_navigation_grid(space, map->settings().navigation, *T_map_robot)));
}

void ShownLayers::show_mesh() {
  changed_ = map_->changed_mesh(changed_, [&](const MeshCube& cube, const Mesh& mesh) {
    PageItem item = mesh_item(cube, mesh);
    if (mesh.triangles.empty())
      board_.remove(item.channel, item.key);
    else
      show_on(board_, std::move(item));
  });
}

}  // namespace lcmslam

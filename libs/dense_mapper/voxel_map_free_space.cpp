// VoxelMap: what later views see through goes.

#include <algorithm>

#include <lcmslam/dense_mapper/voxel_map.hpp>

namespace lcmslam {

std::vector<VoxelMap::Gone> VoxelMap::look_through(const FreeSpaceView& view,
                                                   const Eigen::Isometry3d& T_map_camera,
                                                   const FreeSpaceSettings& settings, std::int32_t turn,
                                                   int first_node) {
  const Eigen::Isometry3f T = T_map_camera.cast<float>();
  const Eigen::Isometry3f T_camera_map = T.inverse();
  const float side = 4 / inverse_size_;  // m, of a block
  std::vector<Gone> gone;
  // One ray of each tile of rotation x rotation cells; after rotation^2 turns each ray had its turn.
  const int n = settings.rotation, offset = turn % (n * n);
  for (int row = offset / n; row < view.rows(); row += n)
    for (int column = offset % n; column < view.columns(); column += n) {
      const float reach = view.reach(column, row);
      const Eigen::Vector3f ray = view.ray(column, row);
      const float step = side / ray.norm();
      for (float z = step; z < reach + step; z += step) {
        const Eigen::Vector3f p = T * Eigen::Vector3f(z * ray);
        if (!voxel_exists(p, inverse_size_)) break;
        const std::int32_t slot = index_.find(voxel_key(voxel_of(p, inverse_size_ / 4)));
        if (slot == VoxelIndex::none) continue;
        Block& block = blocks_[static_cast<std::size_t>(slot)];
        if (block.looked_at == turn) continue;
        block.looked_at = turn;
        look_at(block, view, T_camera_map, first_node, gone);
      }
    }
  if (!gone.empty()) ++frame_;
  surfels_ -= gone.size();
  return gone;
}

void VoxelMap::look_at(Block& block, const FreeSpaceView& view, const Eigen::Isometry3f& T_camera_map,
                       int first_node, std::vector<Gone>& gone) const {
  for (Surfel& s : block.surfels) {
    if (s.anchor < first_node) continue;
    const Visibility visibility = view.judge(T_camera_map * s.point, T_camera_map.linear() * s.normal);
    int evidence = s.evidence;
    if (visibility == Visibility::supported) evidence = std::min(evidence + 1, settings_.max_evidence);
    if (visibility == Visibility::seen_through)
      evidence = std::max(evidence - settings_.miss, settings_.dropped_at);
    s.evidence = static_cast<std::int8_t>(evidence);
    if (evidence <= settings_.dropped_at) gone.push_back({s.point, s.anchor});
  }
  const auto dropped = [&](const Surfel& s) { return s.evidence <= settings_.dropped_at; };
  block.surfels.erase(std::remove_if(block.surfels.begin(), block.surfels.end(), dropped),
                      block.surfels.end());
}

}  // namespace lcmslam

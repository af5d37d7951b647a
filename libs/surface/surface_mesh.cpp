#include <lcmslam/surface/surface_mesh.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

std::vector<bool> changed_since(const VoxelBlocks& blocks, std::int64_t fusion) {
  std::vector<bool> due(blocks.size(), false);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].changed <= fusion) continue;
    for (int n = 0; n < 27; ++n) {
      const std::int32_t found =
          blocks.find(blocks[i].at + Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
      if (found != VoxelBlocks::none) due[static_cast<std::size_t>(found)] = true;
    }
  }
  return due;
}

template <class Pieces>
std::vector<Eigen::Vector3i> drop_gone(const VoxelBlocks& blocks, Pieces& pieces) {
  std::vector<Eigen::Vector3i> gone;
  for (auto piece = pieces.begin(); piece != pieces.end();) {
    const bool stays = blocks.find(piece->second.at) != VoxelBlocks::none;
    if (!stays) gone.push_back(piece->second.at);
    piece = stays ? std::next(piece) : pieces.erase(piece);
  }
  return gone;
}

Eigen::Vector3i cube_of(const Eigen::Vector3i& block) {
  constexpr int n = SurfaceMesh::blocks_per_cube;
  return block.unaryExpr([](int i) { return i >= 0 ? i / n : (i + 1) / n - 1; });
}

/// Vertices on edges that another piece has brought already are that piece's.
void join(const MeshPiece& piece, VoxelIndex& known, Mesh& mesh) {
  std::vector<std::uint32_t> number(piece.edges.size());
  for (std::size_t i = 0; i < piece.edges.size(); ++i) {
    const auto next = static_cast<std::int32_t>(mesh.vertices.size());
    const std::int32_t found = known.insert(piece.edges[i], next);
    number[i] = static_cast<std::uint32_t>(found);
    if (found != next) continue;
    mesh.vertices.push_back(piece.mesh.vertices[i]);
    mesh.normals.push_back(piece.mesh.normals[i]);
    mesh.colours.push_back(piece.mesh.colours[i]);
  }
  for (const auto& t : piece.mesh.triangles)
    mesh.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
}

}  // namespace

SurfaceMesh::SurfaceMesh(const SurfaceSettings& settings)
    : min_weight_(std::max(1.0f, VoxelBlock::full_look * static_cast<float>(settings.min_looks))) {}

void SurfaceMesh::update(const VoxelBlocks& fine, const VoxelBlocks& coarse) {
  fine_blocks_ = &fine;
  ++updates_;
  const std::vector<Eigen::Vector3i> gone = drop_gone(fine, fine_);
  for (const Eigen::Vector3i& at : gone) note_change(false, at);
  for (const Eigen::Vector3i& at : drop_gone(coarse, coarse_)) note_change(true, at);
  const std::vector<bool> due = changed_since(fine, seen_);
  update_level(fine, due, false, fine_);

  // Where the fine surface came or went, the coarse one goes or comes.
  std::vector<bool> coarse_due = changed_since(coarse, seen_);
  const auto mark = [&](const Eigen::Vector3i& at) {
    const Eigen::Vector3f low = fine.block_size() * at.cast<float>();
    for (int corner = 0; corner < 8; ++corner) {
      Eigen::Vector3f point = low;
      for (int axis = 0; axis < 3; ++axis)
        point[axis] +=
            (corner >> axis & 1) ? fine.block_size() + 2 * coarse.voxel_size() : -2 * coarse.voxel_size();
      const std::int32_t found = coarse.find(coarse.block_of(point));
      if (found != VoxelBlocks::none) coarse_due[static_cast<std::size_t>(found)] = true;
    }
  };
  for (std::size_t i = 0; i < fine.size(); ++i)
    if (due[i]) mark(fine[i].at);
  for (const Eigen::Vector3i& at : gone) mark(at);
  update_level(coarse, coarse_due, true, coarse_);

  for (const VoxelBlocks* blocks : {&fine, &coarse})
    for (const VoxelBlocks::Entry& entry : blocks->entries()) seen_ = std::max(seen_, entry.changed);
  fine_blocks_ = nullptr;
}

void SurfaceMesh::update_level(const VoxelBlocks& blocks, const std::vector<bool>& due, bool is_coarse,
                               Pieces& pieces) {
  const float reach = blocks.voxel_size();
  std::function<bool(const Eigen::Vector3f&)> skipped;
  if (is_coarse) skipped = [&](const Eigen::Vector3f& point) { return is_fine(*fine_blocks_, reach, point); };
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!due[i]) continue;
    MeshPiece mesh = mesh_block(blocks, i, min_weight_, skipped);
    const std::uint64_t key = voxel_key(blocks[i].at);
    const bool was_empty = pieces.count(key) == 0;
    if (!mesh.mesh.triangles.empty())
      pieces[key] = {blocks[i].at, std::move(mesh)};
    else if (was_empty)
      continue;
    else
      pieces.erase(key);
    note_change(is_coarse, blocks[i].at);
  }
}

void SurfaceMesh::note_change(bool is_coarse, const Eigen::Vector3i& block) {
  const Eigen::Vector3i at = cube_of(block);
  cubes_[{is_coarse, voxel_key(at)}] = {is_coarse, at, updates_};
}

std::vector<MeshCube> SurfaceMesh::cubes(std::int64_t changed) const {
  std::vector<MeshCube> result;
  for (const auto& cube : cubes_)
    if (cube.second.changed > changed) result.push_back(cube.second);
  return result;
}

Mesh SurfaceMesh::joined(const MeshCube& cube) const {
  const Pieces& pieces = cube.is_coarse ? coarse_ : fine_;
  constexpr int n = blocks_per_cube;
  Mesh mesh;
  VoxelIndex known;
  for (int i = 0; i < n * n * n; ++i) {
    const auto piece = pieces.find(voxel_key(n * cube.at + Eigen::Vector3i(i % n, i / n % n, i / (n * n))));
    if (piece != pieces.end()) join(piece->second.mesh, known, mesh);
  }
  return mesh;
}

bool SurfaceMesh::is_fine(const VoxelBlocks& fine, float reach, const Eigen::Vector3f& point) const {
  const auto shows = [&](const Eigen::Vector3f& p) { return fine_.count(voxel_key(fine.block_of(p))) > 0; };
  if (shows(point)) return true;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3f step = reach * Eigen::Vector3f::Unit(axis);
    if (shows(point + step) || shows(point - step)) return true;
  }
  return false;
}

Mesh SurfaceMesh::joined() const {
  std::size_t most = 0, triangles = 0;  // vertices at most: pieces share some
  for (const Pieces* pieces : {&fine_, &coarse_})
    for (const auto& piece : *pieces) {
      most += piece.second.mesh.edges.size();
      triangles += piece.second.mesh.mesh.triangles.size();
    }
  Mesh mesh;
  mesh.vertices.reserve(most);
  mesh.normals.reserve(most);
  mesh.colours.reserve(most);
  mesh.triangles.reserve(triangles);
  for (const Pieces* pieces : {&fine_, &coarse_}) {
    VoxelIndex known;  // each level has its own grid
    for (const auto& piece : *pieces) join(piece.second.mesh, known, mesh);
  }
  return mesh;
}

std::size_t SurfaceMesh::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Pieces* pieces : {&fine_, &coarse_})
    for (const auto& piece : *pieces) {
      const Mesh& mesh = piece.second.mesh.mesh;
      bytes += sizeof(Piece) +
               mesh.vertices.size() * (2 * sizeof(Eigen::Vector3f) + 3 + sizeof(std::uint64_t)) +
               mesh.triangles.size() * sizeof(mesh.triangles[0]);
    }
  return bytes;
}

}  // namespace lcmslam

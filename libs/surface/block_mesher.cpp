#include <lcmslam/surface/block_mesher.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/surface/cube_table.hpp>

namespace lcmslam {
namespace {

constexpr int side = VoxelBlock::side;
constexpr int margin = 1, span = side + 3;  // voxels -1 .. 9: corners 0 .. 8 and what gradients look at
constexpr int neighbourhood = span * span * span;
constexpr float steepest = 2.5f;  // voxels of distance from a voxel to the next, noise included

/// A block's voxels and those around it, with their own numbering.
class Neighbourhood {
 public:
  Neighbourhood(const VoxelBlocks& blocks, std::size_t block, float min_weight)
      : to_voxels_(blocks.truncation() / VoxelBlock::full_distance / blocks.voxel_size()) {
    const Eigen::Vector3i at = blocks[block].at;
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::int32_t found = blocks.find(at + Eigen::Vector3i(dx, dy, dz));
          if (found != VoxelBlocks::none)
            copy(*blocks[static_cast<std::size_t>(found)].block, {dx, dy, dz}, min_weight);
        }
  }

  static int index(int x, int y, int z) { return x + margin + span * (y + margin + span * (z + margin)); }
  bool known(int i) const { return known_[i]; }
  float distance(int i) const { return distance_[i]; }  // voxels
  const cv::Vec4b& colour(int i) const { return colour_[i]; }

  /// Central differences, one-sided where a neighbour is not known.
  Eigen::Vector3f gradient(int i) const {
    constexpr int steps[] = {1, span, span * span};
    Eigen::Vector3f result = Eigen::Vector3f::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const int before = known_[i - steps[axis]] ? i - steps[axis] : i;
      const int after = known_[i + steps[axis]] ? i + steps[axis] : i;
      if (before != after)
        result[axis] = (distance_[after] - distance_[before]) / (before != i && after != i ? 2.0f : 1.0f);
    }
    return result;
  }

 private:
  void copy(const VoxelBlock& block, const Eigen::Vector3i& step, float min_weight) {
    int first[3], last[3];
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = step[axis] < 0 ? side - 1 : 0;
      last[axis] = step[axis] > 0 ? 1 : side - 1;
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) {
          const int from = VoxelBlock::index(x, y, z);
          const int to = index(x + side * step.x(), y + side * step.y(), z + side * step.z());
          known_[to] = static_cast<float>(block.weight[from]) >= min_weight;
          distance_[to] = to_voxels_ * static_cast<float>(block.distance[from]);
          colour_[to] = {block.blue[from], block.green[from], block.red[from], block.colour_weight[from]};
        }
  }

  float to_voxels_;
  bool known_[neighbourhood] = {};
  float distance_[neighbourhood] = {};
  cv::Vec4b colour_[neighbourhood] = {};
};

class Marcher {
 public:
  Marcher(const VoxelBlocks& blocks, std::size_t block, float min_weight)
      : voxels_(blocks, block, min_weight),
        first_voxel_(side * blocks[block].at),
        voxel_size_(blocks.voxel_size()) {
    std::fill(std::begin(vertex_of_), std::end(vertex_of_), -1);
  }

  Eigen::Vector3f centre(int x, int y, int z) const {
    return voxel_size_ *
           ((first_voxel_ + Eigen::Vector3i(x, y, z)).cast<float>() + Eigen::Vector3f::Constant(0.5f));
  }

  /// Bits of the corners inside; 0 also where no surface can be told.
  int inside(int x, int y, int z) const {
    int bits = 0;
    for (int c = 0; c < 8; ++c) {
      const int i = Neighbourhood::index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
      if (!voxels_.known(i)) return 0;
      bits |= (voxels_.distance(i) < 0) << c;
    }
    return bits == 255 ? 0 : bits;
  }

  bool too_steep(int x, int y, int z, int bits) const {
    for (const CubeEdge& edge : cube_edges()) {
      if ((bits >> edge.from & 1) == (bits >> edge.to & 1)) continue;
      if (std::abs(voxels_.distance(corner(x, y, z, edge.from)) -
                   voxels_.distance(corner(x, y, z, edge.to))) > steepest)
        return true;
    }
    return false;
  }

  void add_triangles(int x, int y, int z, int bits) {
    for (const auto& triangle : cube_table()[static_cast<std::size_t>(bits)]) {
      std::array<std::uint32_t, 3> vertices;
      for (std::size_t k = 0; k < 3; ++k) vertices[k] = vertex(x, y, z, cube_edges()[triangle[k]]);
      piece_.mesh.triangles.push_back(vertices);
    }
  }

  MeshPiece take() { return std::move(piece_); }

 private:
  static int corner(int x, int y, int z, int c) {
    return Neighbourhood::index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
  }

  std::uint32_t vertex(int x, int y, int z, const CubeEdge& edge) {
    const int a = corner(x, y, z, edge.from), b = corner(x, y, z, edge.to);
    std::int32_t& number = vertex_of_[3 * a + edge.axis];
    if (number < 0) {
      number = static_cast<std::int32_t>(piece_.mesh.vertices.size());
      const Eigen::Vector3i voxel =
          first_voxel_ + Eigen::Vector3i(x + (edge.from & 1), y + (edge.from >> 1 & 1), z + (edge.from >> 2));
      add_vertex(a, b, voxel, edge.axis);
    }
    return static_cast<std::uint32_t>(number);
  }

  void add_vertex(int a, int b, const Eigen::Vector3i& voxel, int axis) {
    const float da = voxels_.distance(a), db = voxels_.distance(b);
    const float share = da / (da - db);
    Eigen::Vector3f point = voxel.cast<float>();
    point[axis] += share;
    Eigen::Vector3f normal = (1 - share) * voxels_.gradient(a) + share * voxels_.gradient(b);
    const float length = normal.norm();
    if (length > 0)
      normal /= length;
    else
      normal = Eigen::Vector3f::Unit(axis) * (da < db ? 1.0f : -1.0f);
    Eigen::Vector3i middle = 2 * voxel;
    middle[axis] += 1;
    piece_.mesh.vertices.emplace_back(voxel_size_ * point);
    piece_.mesh.normals.push_back(normal);
    piece_.mesh.colours.push_back(mixed(voxels_.colour(a), voxels_.colour(b), share));
    piece_.edges.push_back(voxel_key(middle));
  }

  /// Of those of the two that are known; grey where none is.
  static cv::Vec3b mixed(const cv::Vec4b& a, const cv::Vec4b& b, float share) {
    if (a[3] == 0 && b[3] == 0) return {128, 128, 128};
    const float of_b = a[3] == 0 ? 1.0f : b[3] == 0 ? 0.0f : share;
    cv::Vec3b colour;
    for (int c = 0; c < 3; ++c)
      colour[c] = static_cast<std::uint8_t>(
          std::lround(static_cast<float>(a[c]) * (1 - of_b) + static_cast<float>(b[c]) * of_b));
    return colour;
  }

  Neighbourhood voxels_;
  Eigen::Vector3i first_voxel_;
  float voxel_size_;
  std::int32_t vertex_of_[3 * neighbourhood];  // by the edge's lower voxel and axis
  MeshPiece piece_;
};

}  // namespace

MeshPiece mesh_block(const VoxelBlocks& blocks, std::size_t block, float min_weight,
                     const std::function<bool(const Eigen::Vector3f&)>& skipped) {
  Marcher marcher(blocks, block, min_weight);
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const int bits = marcher.inside(x, y, z);
        if (bits == 0 || marcher.too_steep(x, y, z, bits)) continue;
        if (skipped && skipped(marcher.centre(x, y, z))) continue;
        marcher.add_triangles(x, y, z, bits);
      }
  return marcher.take();
}

}  // namespace lcmslam

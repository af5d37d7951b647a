#include <lcmslam/surface/cube_table.hpp>

namespace lcmslam {
namespace {

std::array<CubeEdge, 12> make_edges() {
  std::array<CubeEdge, 12> edges{};
  std::size_t count = 0;
  for (std::uint8_t axis = 0; axis < 3; ++axis)
    for (std::uint8_t corner = 0; corner < 8; ++corner)
      if (!(corner >> axis & 1))
        edges[count++] = {corner, static_cast<std::uint8_t>(corner | 1 << axis), axis};
  return edges;
}

int edge_between(int a, int b) {
  for (std::size_t e = 0; e < 12; ++e)
    if ((cube_edges()[e].from == a && cube_edges()[e].to == b) ||
        (cube_edges()[e].from == b && cube_edges()[e].to == a))
      return static_cast<int>(e);
  return -1;
}

/// The corners of a face, counter-clockwise as seen from outside the cube.
std::array<int, 4> face_corners(int axis, bool upper) {
  const int a = 1 << (axis + 1) % 3, b = 1 << (axis + 2) % 3, base = upper ? 1 << axis : 0;
  if (upper) return {base, base | a, base | a | b, base | b};
  return {base, base | b, base | a | b, base | a};
}

CubeTriangles triangles_for(int inside) {
  // next[e]: the edge that follows e on its loop. On each face, walked round, the line enters the inside at
  // one crossing and leaves at the next: from where the walk goes in to where it comes out again.
  std::array<int, 12> next;
  next.fill(-1);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool upper : {false, true}) {
      const std::array<int, 4> corners = face_corners(axis, upper);
      const auto is_inside = [&](std::size_t k) { return (inside >> corners[k % 4] & 1) != 0; };
      for (std::size_t k = 0; k < 4; ++k) {
        if (is_inside(k) || !is_inside(k + 1)) continue;
        std::size_t out = k + 1;
        while (is_inside(out + 1)) ++out;
        const int entry = edge_between(corners[k], corners[(k + 1) % 4]);
        next[static_cast<std::size_t>(entry)] = edge_between(corners[out % 4], corners[(out + 1) % 4]);
      }
    }
  CubeTriangles triangles;
  std::array<bool, 12> done{};
  for (std::size_t first = 0; first < 12; ++first) {
    if (next[first] < 0 || done[first]) continue;
    std::vector<std::uint8_t> loop;
    for (std::size_t e = first; !done[e]; e = static_cast<std::size_t>(next[e])) {
      done[e] = true;
      loop.push_back(static_cast<std::uint8_t>(e));
    }
    for (std::size_t k = 1; k + 1 < loop.size(); ++k) triangles.push_back({loop[0], loop[k], loop[k + 1]});
  }
  return triangles;
}

}  // namespace

const std::array<CubeEdge, 12>& cube_edges() {
  static const std::array<CubeEdge, 12> edges = make_edges();
  return edges;
}

const std::array<CubeTriangles, 256>& cube_table() {
  static const std::array<CubeTriangles, 256> table = [] {
    std::array<CubeTriangles, 256> all;
    for (int inside = 0; inside < 256; ++inside)
      all[static_cast<std::size_t>(inside)] = triangles_for(inside);
    return all;
  }();
  return table;
}

}  // namespace lcmslam

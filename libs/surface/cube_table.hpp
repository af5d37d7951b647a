#pragma once
// Which triangles separate the corners of a cube (marching cubes, Lorensen and Cline 1987). The table is
// computed: around each cube's faces the crossing edges are joined, and the loops that this gives are cut
// into triangles. Where two opposite corners of a face lie inside they are kept apart, whichever cube asks,
// so that neighbouring cubes always fit.

#include <array>
#include <cstdint>
#include <vector>

namespace lcmslam {

/// Corner c of a cube stands at (c & 1, c >> 1 & 1, c >> 2).
struct CubeEdge {
  std::uint8_t from, to;  ///< corners; from stands lower
  std::uint8_t axis;      ///< 0, 1, 2: x, y, z
};
const std::array<CubeEdge, 12>& cube_edges();

/// Triangles of edges for each set of corners that lie inside (bit c: corner c), counter-clockwise as seen
/// from outside.
using CubeTriangles = std::vector<std::array<std::uint8_t, 3>>;
const std::array<CubeTriangles, 256>& cube_table();

}  // namespace lcmslam

#pragma once
// Which depth points the colour camera cannot see because nearer ones stand in front of them.

#include <cstdint>
#include <vector>

#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {

/// Nearest depth for each cell of the colour image. Each point covers a square of `footprint` colour pixels,
/// so that a coarse depth image closes a fine colour image without holes; a cell is half a depth pixel wide.
///
///   splat() rows of points, close(), then ask at().
class DepthBuffer {
 public:
  DepthBuffer(cv::Size colour_size, float footprint);

  /// Points of the colour image, pixels, with their depths, m; those with NaN cover nothing.
  void splat(const float* u, const float* v, const float* z, int columns);
  void close();
  /// Colour pixels, along either side, from a point to the farthest one that it may hide.
  float reach() const { return half_ + 1 / per_pixel_; }
  float at(float u, float v) const { return nearest_(cell(v), cell(u)); }
  /// at() of a row of pixels in two steps, the first vectorised. `pixel`: u, v one after the other; NaN gives
  /// a cell that no point covers, at infinity.
  void find_cells(const float* pixel, int columns, std::int32_t* cell) const;
  float in(std::int32_t cell) const { return nearest_.ptr<float>()[cell]; }

 private:
  int cell(float position) const { return static_cast<int>((position + 0.5f) * per_pixel_) + margin_; }

  float per_pixel_;  // cells
  float half_;       // colour pixels of a splat
  int span_;         // cells that each splat covers at least, along either side
  int margin_;       // cells around the image, for splats that reach over it
  // A splat covers span_ or span_ + 1 cells: one or two windows of span_. Points are put where their windows
  // begin, and close() takes each cell's minimum over the windows that reach it.
  cv::Mat_<float> nearest_;
  std::vector<std::int32_t> first_, right_, down_;  // of a row: where windows begin
};

/// Whether something is nearer than a point at depth z by more than the surface's slope and noise explain.
/// `horizontal`, `vertical`: smaller_step() to its neighbours; `step`: depth pixels to the nearest point that
/// was splatted.
inline bool is_hidden(float gap, int step, float horizontal, float vertical) {
  // Two (thinned) depth pixels of slope in each direction lie between a point and the farthest edge of a
  // splat that covers it.
  return gap > 2 * static_cast<float>(step) * (horizontal + vertical);
}

/// By how much the nearest point stands before one at z: three standard deviations for each of the two.
inline float gap_before(float nearest, float z, float sigma) {
  return z - nearest - 6 * sigma;
}

/// Smaller of the depth steps to two neighbours: the surface's slope, not the edge beside it. NaN: none.
float smaller_step(float before, float z, float after);

/// Sets the pixel of every hidden point to NaN. `buffer` is closed and holds the points of every `step`-th
/// row and column, those whose pixels are known.
void hide_occluded(RegisteredDepth& registered, const DepthBuffer& buffer, int step);

}  // namespace lcmslam

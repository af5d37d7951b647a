#pragma once
// Square patches of the image at any place, angle and pitch: the one kind of input from which both the
// orientation and the descriptor take their Haar wavelets.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <lcmslam/surf/integral.hpp>

namespace lcmslam {

/// Where a patch lies: point (i, j) of an n x n patch is the mean grey value of an upright box of about
/// box_per_pitch * pitch centred on (x, y) + pitch * R(angle) * (i - (n-1)/2, j - (n-1)/2).
struct PatchPose {
  float x = 0, y = 0;          ///< centre, pixels
  float cosine = 1, sine = 0;  ///< of the angle, clockwise in the image
  float pitch = 1;             ///< pixels between neighbours
};

/// Samples patches from box-filtered copies of the image, made once a frame and interpolated between
/// pixels. Large boxes come from copies at half, a quarter, ... of the size, so that no box is wider
/// than five pixels of its copy. Outside the image the border's values continue.
class PatchSampler {
 public:
  /// Wider boxes than the pitch: neighbours overlap, which matters more to a descriptor than sharpness.
  static constexpr float box_per_pitch = 1.35f;
  static constexpr int max_side = 5;  ///< of a box, pixels of its copy
  static constexpr int max_levels = 9;

  /// Which copy serves a pitch.
  struct Copy {
    int level = 0;  ///< pixels of 2^level
    int side = 1;   ///< of the box, in these pixels
  };

  /// Makes the copies for all `pitches` that will be asked for. Keeps a pointer to `integral`.
  void prepare(const IntegralImage& integral, const std::vector<float>& pitches);

  /// After prepare: the least level whose side is at most max_side; tiny images have few levels.
  Copy copy_for(float pitch) const;

  /// Writes n * n means (0..255, to 1/512), row by row; safe from several threads at once. The pitch
  /// must be one of those prepared. `patch` has room for n * n + 7 numbers.
  void sample(const PatchPose& pose, int n, float* patch) const;

 private:
  /// Means times 256, pixel (x, y) of the box that begins at x - side / 2, y - side / 2. The last row
  /// and column are there twice, so that interpolation may always look at the next.
  struct Filtered {
    std::vector<std::uint16_t> means;
    bool ready = false;
  };
  struct Level {
    IntegralImage halved;  ///< unused at level 0
    std::array<Filtered, max_side + 1> by_side;
  };

  const IntegralImage& integral(int level) const {
    return level == 0 ? *integral_ : levels_[static_cast<std::size_t>(level)].halved;
  }
  void filter(Copy copy);

  const IntegralImage* integral_ = nullptr;
  int level_count_ = 1;
  std::array<Level, max_levels> levels_;
};

}  // namespace lcmslam

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include <lcmslam/imaging/depth_filter_parts.hpp>

namespace lcmslam {
namespace {

/// Four pixels at once: most of an image is long runs.
constexpr int at_once = 4;
std::uint64_t four_pixels(const std::uint16_t* depth) {
  std::uint64_t four;
  std::memcpy(&four, depth, sizeof four);
  return four;
}

int skip_invalid(const std::uint16_t* depth, int u, int columns) {
  while (u + at_once <= columns && four_pixels(depth + u) == 0) u += at_once;
  while (u < columns && depth[u] == 0) ++u;
  return u;
}

int skip_valid(const std::uint16_t* depth, int u, int columns) {
  constexpr std::uint64_t ones = 0x0001000100010001, highest = ones << 15;
  // A lane's highest bit is set where it was 0 before 1 was taken off; borrows only begin at such lanes.
  const auto has_zero = [&](std::uint64_t four) { return ((four - ones) & ~four & highest) != 0; };
  while (u + at_once <= columns && !has_zero(four_pixels(depth + u))) u += at_once;
  while (u < columns && depth[u] != 0) ++u;
  return u;
}

/// A horizontal run of valid pixels; runs of neighbouring rows that overlap belong together.
struct Run {
  int row, begin, end;  // columns begin..end-1
  int parent;           // index of another run of the same set, or its own
  int pixels;           // of the whole set, at its root
};

class SpeckleFilter : public DepthFilterPart {
 public:
  explicit SpeckleFilter(const SpeckleFilterSettings& settings) : solid_angle_(settings.min_solid_angle) {}

  void apply(DepthImage& image) override {
    const auto least = std::lround(solid_angle_ / static_cast<double>(image.pitch_x * image.pitch_y));
    if (least <= 1) return;
    runs_.clear();
    int above = 0;  // first run of the row before
    for (int v = 0; v < image.depth.rows; ++v) {
      const int here = static_cast<int>(runs_.size());
      find_runs(image.depth.ptr<std::uint16_t>(v), v, image.depth.cols);
      join_rows(above, here);
      above = here;
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (runs_[root(i)].pixels >= least) continue;
      const Run& run = runs_[i];
      auto* depth = image.depth.ptr<std::uint16_t>(run.row);
      std::fill(depth + run.begin, depth + run.end, std::uint16_t{0});
      std::fill(image.inverse_row(run.row) + run.begin, image.inverse_row(run.row) + run.end, 0.0f);
    }
  }

 private:
  void find_runs(const std::uint16_t* depth, int row, int columns) {
    for (int u = 0; u < columns;) {
      const int begin = skip_invalid(depth, u, columns);
      u = skip_valid(depth, begin, columns);
      if (u > begin) runs_.push_back({row, begin, u, static_cast<int>(runs_.size()), u - begin});
    }
  }

  // Both rows' runs stand from left to right: one walk along both.
  void join_rows(int above, int here) {
    const int end = static_cast<int>(runs_.size());
    for (int a = above, b = here; a < here && b < end;) {
      const Run &upper = run(a), &lower = run(b);
      if (upper.begin < lower.end && lower.begin < upper.end) join(a, b);
      upper.end < lower.end ? ++a : ++b;
    }
  }

  void join(int a, int b) {
    const std::size_t one = root(static_cast<std::size_t>(a)), other = root(static_cast<std::size_t>(b));
    if (one == other) return;
    const std::size_t first = std::min(one, other), second = std::max(one, other);
    runs_[second].parent = static_cast<int>(first);
    runs_[first].pixels += runs_[second].pixels;
  }

  std::size_t root(std::size_t i) {
    while (runs_[i].parent != static_cast<int>(i)) {
      runs_[i].parent = runs_[static_cast<std::size_t>(runs_[i].parent)].parent;  // halves the way
      i = static_cast<std::size_t>(runs_[i].parent);
    }
    return i;
  }

  const Run& run(int i) const { return runs_[static_cast<std::size_t>(i)]; }

  double solid_angle_;
  std::vector<Run> runs_;
};

}  // namespace

std::unique_ptr<DepthFilterPart> make_speckle_filter(const SpeckleFilterSettings& settings) {
  return std::make_unique<SpeckleFilter>(settings);
}

}  // namespace lcmslam

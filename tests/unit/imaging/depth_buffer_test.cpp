// The buffer that tells what hides what, against one that covers its cells one by one.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/occlusion.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
constexpr int width = 90, height = 70, points = 37;  // no multiple of what a processor takes at once

// Few points for many cells, so that each cell's nearest one is often covered by its rim alone. Every ninth
// has no pixel.
struct Row {
  std::vector<float> u, v, z;
  Row(Random& random, int count) {
    for (int i = 0; i < count; ++i) {
      const bool seen = i % 9 != 4;
      u.push_back(seen ? static_cast<float>(random.uniform(-0.5, width - 0.5)) : nan_value);
      v.push_back(seen ? static_cast<float>(random.uniform(-0.5, height - 0.5)) : nan_value);
      z.push_back(static_cast<float>(random.uniform(0.5, 5)));
    }
  }
};

class PlainBuffer {
 public:
  explicit PlainBuffer(float footprint)
      : half_(0.6f * footprint),
        per_pixel_(1 / std::max(1.0f, 0.5f * footprint)),
        nearest_(height + 2, width + 2, std::numeric_limits<float>::infinity()) {}
  void splat(const Row& row) {
    for (std::size_t i = 0; i < row.u.size(); ++i) {
      if (std::isnan(row.u[i])) continue;
      for (int y = std::max(0, cell(row.v[i] - half_)); y <= std::min(height, cell(row.v[i] + half_)); ++y)
        for (int x = std::max(0, cell(row.u[i] - half_)); x <= std::min(width, cell(row.u[i] + half_)); ++x)
          nearest_(y, x) = std::min(nearest_(y, x), row.z[i]);
    }
  }
  float at(float u, float v) const { return nearest_(cell(v), cell(u)); }

 private:
  int cell(float position) const { return static_cast<int>(std::floor((position + 0.5f) * per_pixel_)); }
  float half_, per_pixel_;
  cv::Mat_<float> nearest_;
};

class Footprints : public testing::TestWithParam<float> {};

TEST_P(Footprints, EachCellHasTheNearestPointThatCoversIt) {
  for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2}) {
    const InstructionSet former = limit_instruction_set(set);
    Random random(3);
    DepthBuffer buffer({width, height}, GetParam());
    PlainBuffer plain(GetParam());
    for (int i = 0; i < 8; ++i) {
      const Row row(random, points);
      buffer.splat(row.u.data(), row.v.data(), row.z.data(), points);
      plain.splat(row);
    }
    buffer.close();
    int covered = 0;
    for (int y = 0; y < height; ++y) {
      std::vector<float> pixels;  // of a row, the last one without
      for (int x = 0; x < width; ++x) {
        pixels.push_back(static_cast<float>(x + random.uniform(-0.5, 0.49)));
        pixels.push_back(static_cast<float>(y + random.uniform(-0.5, 0.49)));
      }
      pixels.insert(pixels.end(), {nan_value, nan_value});
      std::vector<std::int32_t> cells(width + 1);
      buffer.find_cells(pixels.data(), width + 1, cells.data());
      for (std::size_t x = 0; x < width; ++x) {
        const float expected = plain.at(pixels[2 * x], pixels[2 * x + 1]);
        ASSERT_EQ(buffer.at(pixels[2 * x], pixels[2 * x + 1]), expected) << x << " " << y;
        ASSERT_EQ(buffer.in(cells[x]), expected) << x << " " << y;
        covered += std::isfinite(expected) ? 1 : 0;
      }
      ASSERT_EQ(buffer.in(cells[width]), std::numeric_limits<float>::infinity());
    }
    limit_instruction_set(former);
    EXPECT_GT(covered, 250);
  }
}

INSTANTIATE_TEST_SUITE_P(ColourPixels, Footprints, testing::Values(0.4f, 1.0f, 1.07f, 1.9f, 2.6f, 5.3f),
                         [](const auto& test) {
                           return std::to_string(std::lround(100 * test.param)) + "Percent";
                         });

}  // namespace
}  // namespace lcmslam

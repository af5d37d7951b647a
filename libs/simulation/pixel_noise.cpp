#include <lcmslam/simulation/pixel_noise.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

const std::array<float, 65536>* make_table() {
  static std::array<float, 65536> table;
  Random random(7);
  // Antithetic pairs, scaled to unit variance: the table's mean is 0 and its variance 1 exactly.
  double sum_of_squares = 0;
  for (std::size_t i = 0; i < table.size(); i += 2) {
    const double value = random.normal();
    table[i] = static_cast<float>(value);
    table[i + 1] = static_cast<float>(-value);
    sum_of_squares += 2 * value * value;
  }
  const auto scale = static_cast<float>(1 / std::sqrt(sum_of_squares / static_cast<double>(table.size())));
  for (float& value : table) value *= scale;
  return &table;
}

}  // namespace

const PixelNoise::Table* PixelNoise::table_ = make_table();

PixelNoise::PixelNoise(std::uint64_t seed, std::uint64_t sensor, std::int64_t time)
    : key_(mix(mix(mix(seed + 0x632be59bd9b4e019ull) + sensor) + static_cast<std::uint64_t>(time))) {}

}  // namespace lcmslam

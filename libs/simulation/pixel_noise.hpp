#pragma once
// Noise as a pure function of (seed, image, pixel): the same bytes whatever the order of calls and
// the number of threads.

#include <array>
#include <cstdint>

namespace lcmslam {

class PixelNoise {
 public:
  /// One image: `sensor` tells cameras of one run apart, `time` their images.
  PixelNoise(std::uint64_t seed, std::uint64_t sensor, std::int64_t time);

  /// 64 random bits of a pixel.
  std::uint64_t bits(std::uint64_t pixel) const { return mix(key_ + pixel * 0x9e3779b97f4a7c15ull); }

  /// Standard normal from 16 random bits (quantiles of a table: |value| < 4.4).
  static float normal(std::uint64_t bits) { return (*table_)[bits & 0xffff]; }
  /// Standard normal from 64 random bits: the sum of three table values, so nearly continuous.
  static float smooth_normal(std::uint64_t bits) {
    return 0.57735027f * (normal(bits) + normal(bits >> 16) + normal(bits >> 32));
  }
  /// Uniform in [0, 1).
  static double uniform(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

 private:
  static std::uint64_t mix(std::uint64_t value);
  using Table = std::array<float, 65536>;
  static const Table* table_;
  std::uint64_t key_;
};

// The finaliser of splitmix64 (Steele et al. 2014).
inline std::uint64_t PixelNoise::mix(std::uint64_t value) {
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ull;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebull;
  return value ^ (value >> 31);
}

}  // namespace lcmslam

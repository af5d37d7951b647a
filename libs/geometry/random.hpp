#pragma once
// Random numbers that are the same on every compiler and machine: the standard library's engines
// are portable, its distributions are not. Every random number of lcmslam comes from one of these,
// seeded from the configuration and passed in.

#include <cstdint>

namespace lcmslam {

class Random {
 public:
  /// Streams of one seed are independent: give each particle or sensor its own.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  std::uint64_t bits();
  /// Uniform in [0, 1).
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform integer in [0, n), n > 0.
  std::uint64_t below(std::uint64_t n);
  /// Standard normal.
  double normal();
  double normal(double mean, double sigma) { return mean + sigma * normal(); }

 private:
  std::uint64_t state_[4];
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace lcmslam

#include "tools/study/score_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

/// What one pair adds to the sums.
struct Pair {
  double repeatability, precision;  // differences
  double correct, peer_correct;
};

struct Sums {
  int pairs = 0;
  Pair sum{};

  void add(const Pair& pair) {
    ++pairs;
    sum.repeatability += pair.repeatability;
    sum.precision += pair.precision;
    sum.correct += pair.correct;
    sum.peer_correct += pair.peer_correct;
  }
  double repeatability() const { return sum.repeatability / pairs; }
  double precision() const { return sum.precision / pairs; }
  double correct() const { return sum.correct / sum.peer_correct; }
};

Interval interval(double value, std::vector<double> resampled) {
  resampled.erase(
      std::remove_if(resampled.begin(), resampled.end(), [](double v) { return !std::isfinite(v); }),
      resampled.end());
  if (resampled.empty()) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {value, nan, nan};
  }
  std::sort(resampled.begin(), resampled.end());
  const auto quantile = [&](double q) {
    return resampled[static_cast<std::size_t>(std::lround(q * static_cast<double>(resampled.size() - 1)))];
  };
  return {value, quantile(0.025), quantile(0.975)};
}

}  // namespace

ScoreComparison compare_scores(const std::vector<std::optional<FeatureScore>>& method,
                               const std::vector<std::optional<FeatureScore>>& peer,
                               const BootstrapSettings& settings) {
  if (settings.resamples < 1 || settings.block < 1)
    throw std::invalid_argument("bootstrap: at least 1 resample and blocks of at least 1");
  if (method.size() != peer.size()) throw std::invalid_argument("bootstrap: scores of different pairs");
  std::vector<std::optional<Pair>> pairs;
  Sums all;
  for (std::size_t i = 0; i < method.size(); ++i) {
    if (method[i].has_value() != peer[i].has_value())
      throw std::invalid_argument("bootstrap: scores of different pairs");
    pairs.emplace_back();
    if (!method[i]) continue;
    pairs.back() = Pair{method[i]->repeatability() - peer[i]->repeatability(),
                        method[i]->precision() - peer[i]->precision(),
                        static_cast<double>(method[i]->correct), static_cast<double>(peer[i]->correct)};
    all.add(*pairs.back());
  }

  std::vector<double> repeatability, precision, correct;
  Random random(1);
  const auto block = static_cast<std::size_t>(settings.block);
  for (int r = 0; r < settings.resamples && all.pairs > 0; ++r) {
    Sums sums;
    for (std::size_t drawn = 0; drawn < pairs.size(); drawn += block) {
      const std::size_t begin = random.below(pairs.size());
      for (std::size_t i = 0; i < std::min(block, pairs.size() - drawn); ++i)
        if (const auto& pair = pairs[(begin + i) % pairs.size()]) sums.add(*pair);
    }
    if (sums.pairs == 0) continue;
    repeatability.push_back(sums.repeatability());
    precision.push_back(sums.precision());
    correct.push_back(sums.correct());
  }
  return {interval(all.repeatability(), std::move(repeatability)),
          interval(all.precision(), std::move(precision)), interval(all.correct(), std::move(correct))};
}

}  // namespace lcmslam

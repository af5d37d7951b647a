#include <lcmslam/fastslam/resampling.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcmslam {
namespace {

// Ancestors for ascending positions in [0, 1): one walk along the cumulative weights.
void pick(const std::vector<double>& weights, const std::vector<double>& positions,
          std::vector<int>& ancestors) {
  const int last = static_cast<int>(weights.size()) - 1;
  int i = 0;
  double cumulative = weights[0];
  for (const double position : positions) {
    while (position >= cumulative && i < last) cumulative += weights[static_cast<std::size_t>(++i)];
    ancestors.push_back(i);
  }
}

// Positions of n independent draws, ascending.
std::vector<double> independent(std::size_t n, Random& random) {
  std::vector<double> positions(n);
  for (double& p : positions) p = random.uniform();
  std::sort(positions.begin(), positions.end());
  return positions;
}

// Liu and Chen 1998: floor(n w_i) copies for certain, the rest drawn from the remainders.
std::vector<int> residual(const std::vector<double>& weights, Random& random) {
  const double n = static_cast<double>(weights.size());
  std::vector<int> ancestors;
  std::vector<double> remainders;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double copies = std::floor(n * weights[i]);
    ancestors.insert(ancestors.end(), static_cast<std::size_t>(copies), static_cast<int>(i));
    remainders.push_back(n * weights[i] - copies);
  }
  ancestors.resize(std::min(ancestors.size(), weights.size()));
  const std::size_t left = weights.size() - ancestors.size();
  if (left > 0) {
    double sum = 0;
    for (const double r : remainders) sum += r;
    for (double& r : remainders) r = sum > 0 ? r / sum : 1 / n;
    pick(remainders, independent(left, random), ancestors);
  }
  std::sort(ancestors.begin(), ancestors.end());
  return ancestors;
}

}  // namespace

std::vector<int> resample(const std::vector<double>& weights, ResamplingScheme scheme, Random& random) {
  if (weights.empty()) return {};
  if (scheme == ResamplingScheme::residual) return residual(weights, random);
  const std::size_t n = weights.size();
  std::vector<double> positions(n);
  if (scheme == ResamplingScheme::multinomial) {
    positions = independent(n, random);
  } else {
    const double shared = random.uniform();
    for (std::size_t i = 0; i < n; ++i) {
      const double offset = scheme == ResamplingScheme::systematic ? shared : random.uniform();
      positions[i] = (static_cast<double>(i) + offset) / static_cast<double>(n);
    }
  }
  std::vector<int> ancestors;
  ancestors.reserve(n);
  pick(weights, positions, ancestors);
  return ancestors;
}

double effective_sample_size(const std::vector<double>& weights) {
  double sum = 0;
  for (const double w : weights) sum += w * w;
  return sum > 0 ? 1 / sum : 0;
}

std::vector<double> normalised_weights(const std::vector<double>& log_weights) {
  double largest = -std::numeric_limits<double>::infinity();
  for (const double l : log_weights)
    if (std::isfinite(l)) largest = std::max(largest, l);
  std::vector<double> weights(log_weights.size(), 1 / static_cast<double>(log_weights.size()));
  if (!std::isfinite(largest)) return weights;
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weights[i] = std::isfinite(log_weights[i]) ? std::exp(log_weights[i] - largest) : 0;
    sum += weights[i];
  }
  for (double& w : weights) w /= sum;
  return weights;
}

}  // namespace lcmslam

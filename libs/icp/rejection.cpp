#include "icp/rejection.hpp"

#include <algorithm>
#include <cmath>

namespace lcmslam {

NormalAngleRejector::NormalAngleRejector(double max_angle) : min_cosine_(std::cos(max_angle)) {}

void NormalAngleRejector::reject(std::vector<Pair>& pairs) const {
  const auto differ = [&](const Pair& p) { return p.moved_normal.dot(p.target_normal) < min_cosine_; };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), differ), pairs.end());
}

void TrimmedRejector::reject(std::vector<Pair>& pairs) const {
  const auto kept = static_cast<std::size_t>(kept_fraction_ * static_cast<double>(pairs.size()));
  if (pairs.empty() || kept >= pairs.size()) return;
  std::vector<double> distances;
  distances.reserve(pairs.size());
  for (const Pair& p : pairs) distances.push_back(p.squared_distance());
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(kept), distances.end());
  const double limit = distances[kept];
  const auto far = [&](const Pair& p) { return p.squared_distance() >= limit; };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), far), pairs.end());
}

void MissingNormalRejector::reject(std::vector<Pair>& pairs) const {
  const auto missing = [](const Pair& p) { return !p.target_normal.allFinite(); };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), missing), pairs.end());
}

std::vector<std::unique_ptr<Rejector>> make_rejectors(const RegistrationSettings& settings) {
  std::vector<std::unique_ptr<Rejector>> chain;
  if (settings.metric == MetricKind::point_to_plane)
    chain.push_back(std::make_unique<MissingNormalRejector>());
  if (settings.max_normal_angle < 3.14)
    chain.push_back(std::make_unique<NormalAngleRejector>(settings.max_normal_angle));
  if (settings.trimmed_fraction < 1)
    chain.push_back(std::make_unique<TrimmedRejector>(settings.trimmed_fraction));
  return chain;
}

}  // namespace lcmslam

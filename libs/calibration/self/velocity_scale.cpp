#include <lcmslam/calibration/self/velocity_scale.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

constexpr double scale_sigma = 0.05;  // before anything is seen
constexpr double slip = 4;            // medians of the differences, beyond which a wheel has slipped

struct Pair {
  Eigen::Vector3d told, real;
};

/// Regression, with the prior as one more equation.
double fitted(const std::vector<Pair>& pairs, double variance) {
  double together = variance / (scale_sigma * scale_sigma), told = together;
  for (const Pair& pair : pairs) together += pair.told.dot(pair.real), told += pair.told.squaredNorm();
  return told > 0 ? together / told : 1;
}

double scale_of(const std::vector<Pair>& pairs) {
  if (pairs.empty()) return 1;
  constexpr int passes = 3;
  double scale = 1;
  std::vector<Pair> kept = pairs;
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<double> differences;
    differences.reserve(pairs.size());
    for (const Pair& pair : pairs) differences.push_back((pair.real - scale * pair.told).norm());
    std::vector<double> sorted = differences;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    kept.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (differences[i] <= slip * *middle) kept.push_back(pairs[i]);
    scale = fitted(kept, *middle * *middle);
  }
  return scale;
}

}  // namespace

VelocityScale velocity_scale(const std::vector<ObservedKeyframe>& keyframes) {
  std::vector<Pair> ways, turns;
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    if (!keyframes[k].motion) continue;
    const Vector6d real = se3_log(keyframes[k - 1].T_world_camera.inverse() * keyframes[k].T_world_camera),
                   told = *keyframes[k].motion;
    ways.push_back({told.head<3>(), real.head<3>()});
    turns.push_back({told.tail<3>(), real.tail<3>()});
  }
  return {scale_of(ways), scale_of(turns)};
}

}  // namespace lcmslam

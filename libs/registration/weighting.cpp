#include <lcmslam/registration/weighting.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {

double HuberKernel::weight(double squared_sigmas) const {
  return squared_sigmas <= width_ * width_ ? 1 : width_ / std::sqrt(squared_sigmas);
}

double GemanMcClureKernel::weight(double squared_sigmas) const {
  const double ratio = 1 + squared_sigmas / squared_width_;
  return 1 / (ratio * ratio);
}

std::unique_ptr<RobustKernel> make_kernel(const RegistrationSettings& settings) {
  switch (settings.kernel) {
    case KernelKind::huber:
      return std::make_unique<HuberKernel>(settings.kernel_width);
    case KernelKind::geman_mcclure:
      return std::make_unique<GemanMcClureKernel>(settings.kernel_width);
    case KernelKind::none:
      break;
  }
  return std::make_unique<NoKernel>();
}

void weigh_pairs(std::vector<Pair>& pairs, const Metric& metric, const RobustKernel& kernel,
                 bool weigh_by_noise, bool settled_lead) {
  if (pairs.empty()) return;
  std::vector<double> squares;  // in variances
  squares.reserve(pairs.size());
  for (const Pair& p : pairs) squares.push_back(metric.squared_error(p) / p.variance);
  std::vector<double> sorted = squares;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double unit = std::max(1.0, 1.4826 * 1.4826 * *middle);

  constexpr double enough = 30, least = 1e-3;  // pairs that lead; what young ones count beside them
  const auto settled =
      static_cast<double>(std::count_if(pairs.begin(), pairs.end(), [](const Pair& p) { return !p.young; }));
  const double share_of_young = settled_lead ? std::max(least, 1 - settled / enough) : 1;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pairs[i].weight = kernel.weight(squares[i] / unit) / (weigh_by_noise ? pairs[i].variance : 1.0) *
                      (pairs[i].young ? share_of_young : 1.0);
}

}  // namespace lcmslam

#include <lcmslam/calibration/self/observability.hpp>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>

namespace lcmslam {
namespace {

/// "12 fx - 0.3 colour_depth.x": how much of each parameter a direction of one prior's length holds.
std::string in_words(const Eigen::VectorXd& direction, const std::vector<int>& parameters,
                     const HeadNumbers& priors) {
  constexpr double named = 0.3;  // of the direction's length
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  const double sign = direction(largest) < 0 ? -1 : 1;
  std::string text;
  for (Eigen::Index k = 0; k < direction.size(); ++k) {
    const double part = sign * direction(k);
    if (std::abs(part) < named) continue;
    const auto p = static_cast<std::size_t>(parameters[static_cast<std::size_t>(k)]);
    char number[64];
    std::snprintf(number, sizeof number, "%s%.3g %s",
                  text.empty() ? (part < 0 ? "-" : "") : (part < 0 ? " - " : " + "),
                  std::abs(part) * priors[p], name_of(static_cast<head::Parameter>(p)).name);
    text += number;
  }
  return text;
}

}  // namespace

// Eigenvectors of the covariance in units of the priors: large ones are what only the start says.
std::vector<std::string> unobserved_directions(const BundleResult& result, double share) {
  std::vector<int> free;
  for (int p = 0; p < head::count; ++p)
    if (!result.held(static_cast<head::Parameter>(p))) free.push_back(p);
  const auto n = static_cast<Eigen::Index>(free.size());
  if (n == 0) return {};
  Eigen::MatrixXd C(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < n; ++k) {
      const int a = free[static_cast<std::size_t>(i)], b = free[static_cast<std::size_t>(k)];
      C(i, k) = result.covariance(a, b) /
                (result.priors[static_cast<std::size_t>(a)] * result.priors[static_cast<std::size_t>(b)]);
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(C);
  std::vector<std::string> directions;
  for (Eigen::Index i = n - 1; i >= 0 && std::sqrt(std::max(0.0, eigen.eigenvalues()(i))) > share; --i)
    directions.push_back(in_words(eigen.eigenvectors().col(i), free, result.priors));
  return directions;
}

}  // namespace lcmslam

#pragma once
// The absolute trajectory error computed a second time, straight from its definition and without
// libs/evaluation: text read with streams, stamps associated by brute force, Umeyama's closed form (1991).

#include <Eigen/Core>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

namespace lcmslam::testing {

struct DefinitionResult {
  std::size_t pairs = 0;
  double rmse = 0;   ///< m
  double scale = 1;  ///< only with_scale
};

/// Position by stamp in s; of equal stamps the last, as a Python dictionary keeps it.
inline std::map<double, Eigen::Vector3d> positions_of(const std::filesystem::path& file) {
  std::map<double, Eigen::Vector3d> positions;
  std::ifstream text(file);
  for (std::string line; std::getline(text, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    double t = 0, x = 0, y = 0, z = 0;
    if (words >> t >> x >> y >> z) positions[t] = {x, y, z};
  }
  return positions;
}

inline DefinitionResult ate_by_definition(const std::filesystem::path& truth_file,
                                          const std::filesystem::path& estimate_file, bool with_scale) {
  const auto truth = positions_of(truth_file), estimate = positions_of(estimate_file);
  // All pairs closer than 20 ms, the closest first; each stamp is used once.
  std::vector<std::tuple<double, double, double>> candidates;
  for (const auto& [a, p] : truth)
    for (const auto& [b, q] : estimate)
      if (std::abs(a - b) < 0.02) candidates.emplace_back(std::abs(a - b), a, b);
  std::sort(candidates.begin(), candidates.end());
  std::set<double> used_truth, used_estimate;
  std::vector<Eigen::Vector3d> p, q;
  for (const auto& [difference, a, b] : candidates) {
    if (used_truth.count(a) > 0 || used_estimate.count(b) > 0) continue;
    used_truth.insert(a);
    used_estimate.insert(b);
    p.push_back(truth.at(a));
    q.push_back(estimate.at(b));
  }
  DefinitionResult result;
  result.pairs = p.size();
  const auto n = static_cast<double>(p.size());

  // p = s R q + t in least squares.
  Eigen::Vector3d p_mean(0, 0, 0), q_mean(0, 0, 0);
  for (std::size_t i = 0; i < p.size(); ++i) p_mean += p[i], q_mean += q[i];
  p_mean /= n;
  q_mean /= n;
  Eigen::Matrix3d W = Eigen::Matrix3d::Zero();
  double q_squares = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    W += (p[i] - p_mean) * (q[i] - q_mean).transpose();
    q_squares += (q[i] - q_mean).squaredNorm();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(W, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d S = Eigen::Matrix3d::Identity();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) S(2, 2) = -1;
  const Eigen::Matrix3d R = svd.matrixU() * S * svd.matrixV().transpose();
  if (with_scale) result.scale = (S * svd.singularValues().asDiagonal()).trace() / q_squares;

  double squares = 0;
  for (std::size_t i = 0; i < p.size(); ++i)
    squares += (result.scale * (R * (q[i] - q_mean)) - (p[i] - p_mean)).squaredNorm();
  result.rmse = std::sqrt(squares / n);
  return result;
}

}  // namespace lcmslam::testing

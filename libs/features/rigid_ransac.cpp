#include <lcmslam/features/rigid_ransac.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include <lcmslam/features/pair_columns.hpp>
#include <lcmslam/geometry/rigid_alignment.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

bool is_covariance(const Eigen::Matrix3d& matrix) {
  return matrix.allFinite() && matrix.llt().info() == Eigen::Success;
}

bool usable(const PointPair& pair) {
  return pair.point_a.allFinite() && pair.point_b.allFinite() && is_covariance(pair.covariance_a) &&
         is_covariance(pair.covariance_b);
}

constexpr int refinement_steps = 10;  // of least squares on all inliers
constexpr double infinite = std::numeric_limits<double>::infinity();

struct Consensus {
  double cost = infinite;  // MSAC (Torr & Zisserman 2000): squared distances, cut off at the limit
  std::vector<int> inliers;
};

// Stops counting, at infinite cost, once it cannot be below `bound`: most hypotheses are wrong and show
// it early.
Consensus consensus(const PairColumns& candidates, const Eigen::Isometry3d& T_a_b, double limit,
                    double bound = infinite) {
  Consensus result{0, {}};
  PairResiduals residuals;
  for (int first = 0; first < candidates.size();) {
    const int count = candidates.measure(T_a_b, first, residuals);
    for (int i = 0; i < count; ++i) {
      const double distance2 = residuals.distance2[i];
      if (distance2 < limit) {
        result.inliers.push_back(first + i);
        result.cost += distance2;
      } else {
        result.cost += limit;
      }
      if (result.cost >= bound) return {};
    }
    first += count;
  }
  return result;
}

bool gauss_newton(const PairColumns& pairs, int max_steps, Eigen::Isometry3d& T_a_b, Matrix6d& covariance) {
  for (int step = 0; step < max_steps; ++step) {
    // In frame b d(exp(xi) p)/d(xi) = [1, -hat(p)]; the normal matrix's blocks, W the information:
    Eigen::Matrix3d translation = Eigen::Matrix3d::Zero();  // W
    Eigen::Matrix3d mixed = Eigen::Matrix3d::Zero();        // hat(p) W
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();     // -hat(p) W hat(p)
    Vector6d gradient = Vector6d::Zero();
    PairResiduals residuals;
    for (int first = 0; first < pairs.size();) {
      const int count = pairs.measure(T_a_b, first, residuals);
      for (int i = 0; i < count; ++i) {
        const auto& w = residuals.information;
        const auto& e = residuals.error;
        Eigen::Matrix3d information;
        information << w[0][i], w[1][i], w[2][i], w[1][i], w[3][i], w[4][i], w[2][i], w[4][i], w[5][i];
        const Eigen::Vector3d weighed = information * Eigen::Vector3d(e[0][i], e[1][i], e[2][i]);
        const Eigen::Matrix3d turn = hat(pairs.point_b(first + i));
        const Eigen::Matrix3d turned = turn * information;
        translation += information;
        mixed += turned;
        rotation -= turned * turn;
        gradient.head<3>() += weighed;
        gradient.tail<3>() += turn * weighed;
      }
      first += count;
    }
    Matrix6d normal;
    normal << translation, mixed.transpose(), mixed, rotation;
    // Scaled to unit diagonal, so that metres and radians compare: near singular is not fixed.
    const Vector6d scale = normal.diagonal().cwiseSqrt().cwiseInverse();
    if (!scale.allFinite()) return false;
    const Matrix6d scaled = scale.asDiagonal() * normal * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scaled);
    if (!(eigen.eigenvalues().minCoeff() > 1e-10)) return false;
    const Matrix6d inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                             eigen.eigenvectors().transpose();
    covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
    const Vector6d update = covariance * gradient;
    T_a_b = T_a_b * se3_exp(update);
    if (update.dot(gradient) < 1e-12) break;  // a step of a millionth standard deviation
  }
  // Products of many rotations drift from orthonormal.
  T_a_b.linear() = Eigen::Quaterniond(T_a_b.linear()).normalized().toRotationMatrix();
  return true;
}

// Local optimisation (Chum, Matas & Kittler 2003): three points fix the motion only roughly, so that many
// inliers lie beyond the limit. Least squares on whoever is within a wider limit, which narrows; kept
// when it ends better.
void optimise(const std::vector<PointPair>& candidates, const PairColumns& columns, double limit,
              Eigen::Isometry3d& T_a_b, Consensus& best) {
  Eigen::Isometry3d refined = T_a_b;
  for (const double width : {4., 2., 1.}) {
    const Consensus near = consensus(columns, refined, width * limit);
    Matrix6d covariance;
    if (near.inliers.size() < 3 ||
        !gauss_newton(PairColumns(candidates, near.inliers), 1, refined, covariance))
      return;
    Consensus found = consensus(columns, refined, limit, best.cost);
    if (found.cost >= best.cost) continue;
    best = std::move(found);
    T_a_b = refined;
  }
}

// A rigid motion keeps distances: most wrong samples show before any alignment. The slack is the
// inlier limit applied to the length's own standard deviation.
bool lengths_agree(const PointPair& p, const PointPair& q, double limit) {
  const Eigen::Vector3d edge_a = p.point_a - q.point_a, edge_b = p.point_b - q.point_b;
  const double length_a = edge_a.norm(), length_b = edge_b.norm();
  if (!(length_a > 0) || !(length_b > 0)) return false;
  const Eigen::Vector3d u = edge_a / length_a, v = edge_b / length_b;
  const double variance =
      u.dot((p.covariance_a + q.covariance_a) * u) + v.dot((p.covariance_b + q.covariance_b) * v);
  return (length_a - length_b) * (length_a - length_b) < limit * variance;
}

std::optional<Eigen::Isometry3d> hypothesis(const std::vector<PointPair>& candidates, double limit,
                                            Random& random) {
  std::size_t sample[3];
  for (int k = 0; k < 3; ++k) {
    bool repeated = true;
    while (repeated) {
      sample[k] = random.below(candidates.size());
      repeated = std::find(sample, sample + k, sample[k]) != sample + k;
    }
  }
  std::vector<Eigen::Vector3d> source, target;
  for (int k = 0; k < 3; ++k) {
    const PointPair& pair = candidates[sample[k]];
    if (!lengths_agree(pair, candidates[sample[(k + 1) % 3]], limit)) return std::nullopt;
    source.push_back(pair.point_b);
    target.push_back(pair.point_a);
  }
  return align_svd(source, target);
}

// Samples needed so that one of three inliers is among them with the given confidence.
double needed_iterations(double inlier_fraction, double confidence) {
  const double all_inliers = inlier_fraction * inlier_fraction * inlier_fraction;
  if (all_inliers >= 1) return 1;
  return std::log(1 - confidence) / std::log1p(-all_inliers);
}

// Points on one line leave the turn about it free. Noise spreads them and makes the turn seem known, so
// the spread along the second of their axes is held against the noise along it: nine times its variance
// is three standard deviations, and lets the noise pretend a ninth of the information.
bool fix_rotation(const std::vector<PointPair>& pairs, const std::vector<int>& indices) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero(), noise = Eigen::Matrix3d::Zero();
  const double weight = 1 / static_cast<double>(indices.size());
  for (int i : indices) mean += weight * pairs[static_cast<std::size_t>(i)].point_b;
  for (int i : indices) {
    const PointPair& pair = pairs[static_cast<std::size_t>(i)];
    spread += weight * (pair.point_b - mean) * (pair.point_b - mean).transpose();
    noise += weight * pair.covariance_b;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  const Eigen::Vector3d second = axes.eigenvectors().col(1);
  return axes.eigenvalues()[1] > 9 * second.dot(noise * second);
}

RigidRansacResult failure(RigidRansacResult result, const std::string& reason) {
  result.success = false;
  result.reason = reason;
  return result;
}

RigidRansacResult align_usable(const std::vector<PointPair>& candidates, const RigidRansacSettings& settings,
                               Random& random) {
  constexpr const char* degenerate = "the inliers do not fix the motion (on one line or in one place)";
  RigidRansacResult result;
  const auto too_few = [&](std::size_t count, const std::string& what) {
    return std::to_string(count) + " " + what + ", " + std::to_string(settings.min_inliers) + " needed";
  };
  const auto enough = static_cast<std::size_t>(settings.min_inliers);
  if (candidates.size() < enough) return failure(result, too_few(candidates.size(), "matches with depth"));

  // Draw, count, keep the best and better it.
  const PairColumns columns(candidates);
  Consensus best;
  double needed = settings.max_iterations;
  while (result.iterations < std::min<double>(needed, settings.max_iterations)) {
    ++result.iterations;
    const auto T_a_b = hypothesis(candidates, settings.chi_square, random);
    if (!T_a_b) continue;
    Consensus found = consensus(columns, *T_a_b, settings.chi_square, best.cost);
    if (found.cost >= best.cost) continue;
    best = std::move(found);
    result.T_a_b = *T_a_b;
    optimise(candidates, columns, settings.chi_square, result.T_a_b, best);
    const double fraction = static_cast<double>(best.inliers.size()) / static_cast<double>(candidates.size());
    needed = needed_iterations(fraction, settings.confidence);
  }
  result.inliers = best.inliers;

  // Least squares on the inliers, then whoever agrees with it, until the set stays the same.
  for (int round = 0; round < settings.max_refinements; ++round) {
    if (result.inliers.size() < 3) break;
    if (!gauss_newton(PairColumns(candidates, result.inliers), refinement_steps, result.T_a_b,
                      result.covariance))
      return failure(result, degenerate);
    Consensus found = consensus(columns, result.T_a_b, settings.chi_square);
    const bool same = found.inliers == result.inliers;
    result.inliers = std::move(found.inliers);
    if (same) break;
  }
  if (result.inliers.size() < enough) return failure(result, too_few(result.inliers.size(), "inliers"));
  if (!fix_rotation(candidates, result.inliers)) return failure(result, degenerate);
  result.success = true;
  return result;
}

}  // namespace

bool refine_rigid(const std::vector<PointPair>& pairs, const std::vector<int>& indices,
                  Eigen::Isometry3d& T_a_b, Matrix6d& covariance) {
  return gauss_newton(PairColumns(pairs, indices), refinement_steps, T_a_b, covariance);
}

RigidRansacResult align_ransac(const std::vector<PointPair>& pairs, const RigidRansacSettings& settings,
                               Random& random) {
  check(settings, "rigid RANSAC");
  std::vector<PointPair> candidates;
  std::vector<int> index_of;  // each candidate's in `pairs`
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!usable(pairs[i])) continue;
    candidates.push_back(pairs[i]);
    index_of.push_back(static_cast<int>(i));
  }
  RigidRansacResult result = align_usable(candidates, settings, random);
  for (int& index : result.inliers) index = index_of[static_cast<std::size_t>(index)];
  return result;
}

RigidRansacResult align_ransac(const FeatureFrame& a, const FeatureFrame& b,
                               const std::vector<Match>& matches, const RigidRansacSettings& settings,
                               Random& random) {
  std::vector<PointPair> pairs;
  std::vector<int> match_of_pair;
  const auto has_point = [](const Feature& f) {
    return f.kind == MeasurementKind::point && f.point.allFinite() && f.point.z() > 0 && f.depth_sigma > 0;
  };
  const auto feature_of = [&](const FeatureFrame& frame, const char* name, int index,
                              std::size_t m) -> auto& {
    if (index < 0 || static_cast<std::size_t>(index) >= frame.features.size())
      throw std::invalid_argument("rigid RANSAC: match " + std::to_string(m) + " names feature " +
                                  std::to_string(index) + " of frame " + name + ", which has " +
                                  std::to_string(frame.features.size()));
    return frame.features[static_cast<std::size_t>(index)];
  };
  for (std::size_t m = 0; m < matches.size(); ++m) {
    const Feature& feature_a = feature_of(a, "a", matches[m].a, m);
    const Feature& feature_b = feature_of(b, "b", matches[m].b, m);
    if (!has_point(feature_a) || !has_point(feature_b)) continue;
    pairs.push_back({feature_a.point.cast<double>(), feature_b.point.cast<double>(),
                     point_covariance(feature_a, a), point_covariance(feature_b, b)});
    match_of_pair.push_back(static_cast<int>(m));
  }
  RigidRansacResult result = align_ransac(pairs, settings, random);
  for (int& index : result.inliers) index = match_of_pair[static_cast<std::size_t>(index)];
  return result;
}

}  // namespace lcmslam

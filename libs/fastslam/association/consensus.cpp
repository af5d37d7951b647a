#include <lcmslam/fastslam/association/consensus.hpp>

#include <Eigen/Cholesky>
#include <cmath>

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/geometry/rigid_alignment.hpp>

namespace lcmslam {
namespace {

constexpr int hypothesis_count = 60;
// Accepts errors up to 2.6 sigma of the whole (trace) innovation covariance: at least 99 % of right
// matches, whatever the covariance's shape and the pose's rotation.
constexpr double trace_gate = 6.6;

double trace(const ObservedLandmark& pair) {
  return pair.landmark.covariance.trace() + pair.measurement.covariance.trace();
}

int mark_inliers(const std::vector<ObservedLandmark>& pairs, const Eigen::Isometry3d& T,
                 std::vector<char>& inlier) {
  int count = 0;
  inlier.assign(pairs.size(), 0);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double error2 = (T * pairs[i].measurement.value - pairs[i].landmark.mean).squaredNorm();
    if (error2 > trace_gate * trace(pairs[i])) continue;
    inlier[i] = 1;
    ++count;
  }
  return count;
}

// Least squares in the plane, closed form: heading from the summed cross and dot products.
std::optional<Eigen::Isometry3d> align_planar(const std::vector<Eigen::Vector3d>& source,
                                              const std::vector<Eigen::Vector3d>& target,
                                              const std::vector<double>& weights) {
  Eigen::Vector3d p_mean = Eigen::Vector3d::Zero(), q_mean = Eigen::Vector3d::Zero();
  double sum = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    p_mean += weights[i] * source[i];
    q_mean += weights[i] * target[i];
    sum += weights[i];
  }
  p_mean /= sum;
  q_mean /= sum;
  double cosine = 0, sine = 0, spread = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d p = source[i] - p_mean, q = target[i] - q_mean;
    cosine += weights[i] * (p.x() * q.x() + p.y() * q.y());
    sine += weights[i] * (p.x() * q.y() - p.y() * q.x());
    spread += weights[i] * p.head<2>().squaredNorm();
  }
  if (spread < 0.01 * sum) return std::nullopt;  // closer than about 10 cm to a single point
  const double heading = std::atan2(sine, cosine);
  Eigen::Isometry3d T = planar_pose(0, 0, heading);
  const Eigen::Vector3d t = q_mean - T * p_mean;
  return planar_pose(t.x(), t.y(), heading);
}

std::optional<Eigen::Isometry3d> align(const std::vector<ObservedLandmark>& pairs,
                                       const std::vector<std::size_t>& chosen, bool planar) {
  std::vector<Eigen::Vector3d> source, target;
  std::vector<double> weights;
  for (const std::size_t i : chosen) {
    source.push_back(pairs[i].measurement.value);
    target.push_back(pairs[i].landmark.mean);
    weights.push_back(1 / trace(pairs[i]));
  }
  return planar ? align_planar(source, target, weights) : align_svd(source, target, weights);
}

template <int D>
Matrix6d covariance_of(const std::vector<ObservedLandmark>& pairs, const std::vector<char>& inlier,
                       const Eigen::Isometry3d& T) {
  using Space = PoseSpace<D>;
  typename Space::Matrix information = Space::Matrix::Identity() * 1e-6;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!inlier[i]) continue;
    const Innovation innovation = innovate(pairs[i].landmark, pairs[i].measurement, T);
    const auto J = Space::residual_jacobian(pairs[i].measurement.value - innovation.residual);
    information += J.transpose() * innovation.inverse * J;
  }
  const typename Space::Matrix covariance = information.llt().solve(Space::Matrix::Identity());
  return Space::expand(covariance);
}

}  // namespace

std::optional<Consensus> find_consensus(const std::vector<ObservedLandmark>& pairs,
                                        const Eigen::Isometry3d& T_world_prior, bool planar, int minimum,
                                        Random& random) {
  if (pairs.size() < static_cast<std::size_t>(minimum)) return std::nullopt;
  Consensus best;
  best.T_world_robot = T_world_prior;
  best.inliers = mark_inliers(pairs, T_world_prior, best.inlier);

  std::vector<char> inlier;
  const auto offer = [&](const Eigen::Isometry3d& T) {
    const int count = mark_inliers(pairs, T, inlier);
    if (count <= best.inliers) return;
    best.T_world_robot = T;
    best.inliers = count;
    best.inlier = inlier;
  };
  std::vector<std::size_t> chosen(planar ? 2 : 3);
  for (int hypothesis = 0; hypothesis < hypothesis_count; ++hypothesis) {
    for (std::size_t& i : chosen) i = static_cast<std::size_t>(random.below(pairs.size()));
    if (const auto T = align(pairs, chosen, planar)) offer(*T);
  }
  if (best.inliers < minimum) return std::nullopt;

  for (int round = 0; round < 3; ++round) {  // least squares over all that agree
    chosen.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (best.inlier[i]) chosen.push_back(i);
    const auto T = align(pairs, chosen, planar);
    if (!T) return std::nullopt;
    std::vector<char> refined;
    const int count = mark_inliers(pairs, *T, refined);
    if (count < minimum || 10 * count < 9 * best.inliers) break;
    best.T_world_robot = *T;
    best.inliers = count;
    best.inlier = refined;
  }
  best.covariance = planar ? covariance_of<3>(pairs, best.inlier, best.T_world_robot)
                           : covariance_of<6>(pairs, best.inlier, best.T_world_robot);
  return best;
}

}  // namespace lcmslam

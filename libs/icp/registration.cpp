#include "icp/registration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "icp/kd_tree.hpp"
#include "icp/projective_target.hpp"
#include "icp/rejection.hpp"
#include "icp/selection.hpp"
#include "icp/voxel_map.hpp"
#include "icp/weighting.hpp"

namespace lcmslam {
namespace {

std::vector<Pair> find_pairs(const Cloud& source, const std::vector<std::size_t>& selected,
                             const Target& target, const Eigen::Isometry3d& T, double max_distance,
                             double noise_floor) {
  const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<Pair> pairs;
  pairs.reserve(selected.size());
  TargetPoint found;
  for (const std::size_t i : selected) {
    Pair pair;
    pair.source = source.points[i].cast<double>();
    pair.moved = T * pair.source;
    if (!target.find(pair.moved.cast<float>(), static_cast<float>(max_distance), found)) continue;
    pair.target = found.point.cast<double>();
    pair.target_normal = found.normal.cast<double>();
    pair.moved_normal =
        source.has_normals() ? Eigen::Vector3d(T.linear() * source.normals[i].cast<double>()) : unknown;
    const double sigma = source.sigmas.empty() ? 0 : static_cast<double>(source.sigmas[i]);
    const double target_sigma = static_cast<double>(found.sigma);
    pair.variance = sigma * sigma + target_sigma * target_sigma + noise_floor * noise_floor;
    if (std::isfinite(pair.variance) && pair.variance > 0) pairs.push_back(pair);
  }
  return pairs;
}

double rms(const std::vector<Pair>& pairs, const Metric& metric) {
  double sum = 0;
  for (const Pair& p : pairs) sum += metric.squared_error(p);
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

int count_inliers(const std::vector<Pair>& pairs, const Metric& metric) {
  const auto inlier = [&](const Pair& p) { return metric.squared_error(p) < 9 * p.variance; };
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), inlier));
}

// Three-sigma rule on the pairs' distances (Zhang 1994), never growing.
double next_limit(const std::vector<Pair>& pairs, double limit, const RegistrationSettings& settings) {
  if (settings.distance_sigmas <= 0) return limit;
  const double spread = rms(pairs, PointToPoint());
  return std::clamp(settings.distance_sigmas * spread, std::min(settings.min_distance, limit), limit);
}

bool is_small(const Eigen::Isometry3d& before, const Eigen::Isometry3d& after,
              const RegistrationSettings& settings) {
  const Eigen::Isometry3d step = before.inverse() * after;
  return step.translation().norm() < settings.epsilon_translation &&
         rotation_angle(step) < settings.epsilon_rotation;
}

bool rms_settled(const std::vector<double>& history, double epsilon) {
  const std::size_t n = history.size();
  return n >= 2 && std::abs(history[n - 1] - history[n - 2]) < epsilon;
}

}  // namespace

std::string to_string(StopReason reason) {
  switch (reason) {
    case StopReason::converged:
      return "converged";
    case StopReason::max_iterations:
      return "max_iterations";
    case StopReason::too_few_pairs:
      return "too_few_pairs";
    case StopReason::degenerate:
      return "degenerate";
  }
  return "unknown";
}

RegistrationResult register_cloud(const Cloud& source, const Target& target, const Eigen::Isometry3d& T_start,
                                  const RegistrationSettings& settings, const Prior* prior) {
  const auto solver = make_solver(settings, prior);
  const auto metric = make_metric(settings.metric);
  const auto kernel = make_kernel(settings);
  const auto rejectors = make_rejectors(settings);
  const std::vector<std::size_t> selected = select_points(source, settings);

  RegistrationResult result;
  if (!T_start.matrix().allFinite()) return result;
  Eigen::Isometry3d& T = result.T_target_source;
  T = T_start;
  double limit = settings.max_distance;
  result.stop = StopReason::max_iterations;
  std::vector<Pair> pairs;
  for (int iteration = 0; iteration < settings.max_iterations; ++iteration) {
    pairs = find_pairs(source, selected, target, T, limit, settings.noise_floor);
    for (const auto& rejector : rejectors) rejector->reject(pairs);
    if (pairs.empty() || static_cast<int>(pairs.size()) < settings.min_pairs) {
      result.stop = StopReason::too_few_pairs;
      break;
    }
    weigh_pairs(pairs, *metric, *kernel, settings.weigh_by_noise);
    result.rms.push_back(rms(pairs, *metric));

    const auto T_next = solver->solve(pairs, T);
    if (!T_next) {
      result.stop = StopReason::degenerate;
      break;
    }
    const bool arrived = is_small(T, *T_next, settings) || rms_settled(result.rms, settings.epsilon_rms);
    const double next = next_limit(pairs, limit, settings);
    T = *T_next;
    if (arrived && next > 0.9 * limit) {
      result.stop = StopReason::converged;
      break;
    }
    limit = next;
  }

  result.pairs = static_cast<int>(pairs.size());
  if (pairs.empty()) return result;
  const Observability seen = observe(pairs, *metric, T, settings);
  result.covariance = seen.covariance(prior);
  result.observability = seen.shares;
  result.degenerate = seen.degenerate_twists();
  result.inliers = count_inliers(pairs, *metric);
  result.overlap = static_cast<double>(pairs.size()) / static_cast<double>(selected.size());
  return result;
}

std::unique_ptr<Target> make_target(const Cloud& cloud, CorrespondenceKind kind,
                                    const Eigen::Isometry3d& T_target_camera) {
  switch (kind) {
    case CorrespondenceKind::projective:
      return std::make_unique<ProjectiveTarget>(cloud, T_target_camera);
    case CorrespondenceKind::voxel_map: {
      auto map = std::make_unique<VoxelMap>();
      map->insert(cloud, T_target_camera.translation());
      return map;
    }
    case CorrespondenceKind::kd_tree:
      break;
  }
  return std::make_unique<KdTreeTarget>(cloud);
}

}  // namespace lcmslam

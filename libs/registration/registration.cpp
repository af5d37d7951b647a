#include <lcmslam/registration/registration.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/preparation.hpp>
#include <lcmslam/registration/selection.hpp>
#include <lcmslam/registration/stop_criterion.hpp>
#include <lcmslam/registration/weighting.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

/// Partners of the selected points, iteration by iteration.
class PairSearch {
 public:
  PairSearch(const Cloud& source, const Target& target, const RegistrationSettings& settings)
      : source_(source),
        target_(target),
        selected_(select_points(source, settings)),
        noise_floor_(settings.noise_floor) {
    if (target.finds_nearest()) last_.resize(selected_.size());
  }

  std::size_t selected() const { return selected_.size(); }

  void find(const Eigen::Isometry3d& T, double max_distance, std::vector<Pair>& pairs) {
    const auto reach = static_cast<float>(max_distance);
    pairs.clear();
    pairs.reserve(selected_.size());
    for (std::size_t k = 0; k < selected_.size(); ++k) {
      const std::size_t i = selected_[k];
      Pair pair;
      pair.index = i;
      pair.source = source_.points[i].cast<double>();
      pair.moved = T * pair.source;
      pair.moved_normal =
          source_.has_normals() ? Eigen::Vector3d(T.linear() * source_.normals[i].cast<double>()) : unknown;
      const Eigen::Vector3f moved = pair.moved.cast<float>();
      if (!last_.empty()) {
        if (find_nearest(last_[k], moved, reach)) add(pair, last_[k].found, pairs);
        continue;
      }
      TargetPoint found;
      if (target_.find_along(moved, pair.moved_normal.cast<float>(), reach, found)) add(pair, found, pairs);
    }
  }

 private:
  /// What was last found for a point of the source.
  struct Last {
    Eigen::Vector3f at = Eigen::Vector3f::Constant(TargetPoint::unknown);  // where the point was
    TargetPoint found;
    bool is_found = false;
    float others = 0;            // other points of the target were no nearer to it
    Eigen::Vector3f known = at;  // some point of the target that was near
  };

  // While a point has moved less than what its partner was nearer than all others, that is still the nearest:
  // in later iterations nearly all are. Else the nearest is no farther than one that was near.
  bool find_nearest(Last& last, const Eigen::Vector3f& moved, float reach) const {
    constexpr float spare = 2e-4f;  // m, for rounding
    const float others = last.others - (moved - last.at).norm() - spare;
    if (last.is_found) {
      const Eigen::Vector3f away = last.found.point - moved;
      if (away.norm() < others) return !(away.squaredNorm() > reach * reach);
    } else if (reach < others) {
      return false;
    }
    const float distance = 1.0001f * (last.known - moved).norm() + 1e-6f;
    const float within = distance < reach ? distance : reach;  // also where there was none
    last.at = moved;
    last.is_found = target_.find_nearest(moved, within, last.found, last.others);
    if (last.is_found) last.known = last.found.point;
    return last.is_found;
  }

  void add(Pair& pair, const TargetPoint& found, std::vector<Pair>& pairs) const {
    pair.target = found.point.cast<double>();
    pair.target_normal = found.normal.cast<double>();
    if (!source_.intensities.empty())
      pair.source_intensity = static_cast<double>(source_.intensities[pair.index]);
    pair.target_intensity = static_cast<double>(found.intensity);
    pair.target_gradient = found.gradient.cast<double>();
    pair.boundary = found.boundary;
    pair.young = found.young;
    const double sigma = source_.sigmas.empty() ? 0 : static_cast<double>(source_.sigmas[pair.index]);
    const double target_sigma = static_cast<double>(found.sigma);
    pair.variance = sigma * sigma + target_sigma * target_sigma + noise_floor_ * noise_floor_;
    if (std::isfinite(pair.variance) && pair.variance > 0) pairs.push_back(pair);
  }

  const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const Cloud& source_;
  const Target& target_;
  std::vector<std::size_t> selected_;
  double noise_floor_;
  std::vector<Last> last_;  // of each selected point; empty: partners are not the nearest
};

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

// Kernels, limits and inliers are there for errors that smoothing does not take: they go by the noise as it
// was. What the pairs that are left know beside a prior goes by the noise that is left.
void weigh_by_noise_left(std::vector<Pair>& pairs, double noise_left) {
  for (Pair& p : pairs) {
    p.variance *= noise_left * noise_left;
    p.weight /= noise_left * noise_left;
  }
}

void remove_young(std::vector<Pair>& pairs) {
  const auto first_young = std::remove_if(pairs.begin(), pairs.end(), [](const Pair& p) { return p.young; });
  pairs.erase(first_young, pairs.end());
}

SettledPairs what_settled_say(std::vector<Pair> pairs, const Metric& metric, const Eigen::Isometry3d& T,
                              const RegistrationSettings& settings) {
  remove_young(pairs);
  const Observability seen = observe(pairs, metric, T, settings);
  const Matrix6d inverse_basis = seen.basis.inverse();
  return {inverse_basis.transpose() * (seen.information / seen.excess) * inverse_basis,
          inverse_basis.transpose() * (seen.gradient / seen.excess)};
}

// What the last pairs say about the result.
void report(const std::vector<Pair>& pairs, std::size_t selected, const Metric& metric,
            const RegistrationSettings& settings, const Prior* prior, RegistrationResult& result) {
  result.pairs = static_cast<int>(pairs.size());
  if (pairs.empty()) return;
  const Observability seen = observe(pairs, metric, result.T_target_source, settings);
  result.covariance = seen.covariance(prior);
  result.observability = seen.shares;
  result.degenerate = seen.degenerate_twists();
  result.inliers = count_inliers(pairs, metric);
  result.overlap = static_cast<double>(pairs.size()) / static_cast<double>(selected);
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

std::string to_string(MetricKind kind) {
  static const char* const names[] = {"point-to-point", "point-to-plane", "plane-to-plane"};
  return names[static_cast<std::size_t>(kind)];
}

std::string to_string(SolverKind kind) {
  static const char* const names[] = {
      "SVD",         "SVD uncorrected",        "quaternion",   "quaternion as printed",
      "small angle", "small angle as printed", "Gauss-Newton", "Levenberg-Marquardt"};
  return names[static_cast<std::size_t>(kind)];
}

std::vector<std::string> degenerate_names(const RegistrationResult& result) {
  static const char* const names[] = {"x", "y", "z", "roll", "pitch", "yaw"};
  std::vector<std::string> text;
  for (const Vector6d& direction : result.degenerate) {
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    text.emplace_back(names[largest]);
  }
  return text;
}

RegistrationResult register_cloud(const Cloud& source, const Target& target, const Eigen::Isometry3d& T_start,
                                  const RegistrationSettings& settings, const Prior* prior,
                                  const SensorViews* views, double noise_left) {
  const auto solver = make_solver(settings, prior);
  const auto metric = make_metric(settings);
  const auto kernel = make_kernel(settings);
  const auto rejectors = make_rejectors(settings, source, views);
  const StopCriterion stop(settings);
  PairSearch search(source, target, settings);

  RegistrationResult result;
  if (!T_start.matrix().allFinite()) return result;
  Eigen::Isometry3d& T = result.T_target_source;
  T = T_start;
  double limit = settings.max_distance;
  result.stop = StopReason::max_iterations;
  Eigen::Isometry3d T_pairs = T;  // where the pairs were found
  std::vector<Pair> pairs;
  for (int iteration = 0; iteration < settings.max_iterations; ++iteration) {
    search.find(T, limit, pairs);
    if (settings.settled_alone) remove_young(pairs);
    for (const auto& rejector : rejectors) rejector->reject(pairs, T);
    if (pairs.empty() || static_cast<int>(pairs.size()) < settings.min_pairs) {
      result.stop = StopReason::too_few_pairs;
      break;
    }
    weigh_pairs(pairs, *metric, *kernel, settings.weigh_by_noise, settings.settled_lead);
    result.rms.push_back(rms(pairs, *metric));

    const auto T_next = solver->solve(pairs, T);
    if (!T_next) {
      result.stop = StopReason::degenerate;
      break;
    }
    const bool arrived = stop.arrived(T, *T_next, result.rms);
    const double next = next_limit(pairs, limit, settings);
    T_pairs = std::exchange(T, *T_next);
    if (arrived && next > 0.9 * limit) {
      result.stop = StopReason::converged;
      break;
    }
    limit = next;
  }

  report(pairs, search.selected(), *metric, settings, prior, result);
  if (settings.settled_lead) result.settled = what_settled_say(pairs, *metric, T, settings);
  if (result.ok() && settings.weigh_by_noise && noise_left < 1) {
    weigh_by_noise_left(pairs, noise_left);
    if (const auto settled = solver->solve(pairs, T_pairs)) T = *settled;
    result.covariance = observe(pairs, *metric, T, settings).covariance(prior);
  }
  return result;
}

RegistrationResult look(const Cloud& source, const Target& target, const Eigen::Isometry3d& T,
                        const RegistrationSettings& settings) {
  RegistrationResult result;
  result.T_target_source = T;
  const auto metric = make_metric(settings);
  PairSearch search(source, target, settings);
  std::vector<Pair> pairs;
  search.find(T, settings.max_distance, pairs);
  for (const auto& rejector : make_rejectors(settings, source)) rejector->reject(pairs, T);
  if (static_cast<int>(pairs.size()) < std::max(1, settings.min_pairs)) return result;
  weigh_pairs(pairs, *metric, *make_kernel(settings), settings.weigh_by_noise);
  result.rms.push_back(rms(pairs, *metric));
  result.stop = StopReason::converged;
  report(pairs, search.selected(), *metric, settings, nullptr, result);
  return result;
}

RegistrationResult register_clouds(const Cloud& source, const Cloud& target, const Eigen::Isometry3d& T_start,
                                   const std::vector<RegistrationSettings>& passes) {
  if (passes.empty()) throw std::invalid_argument("registration: no passes");
  for (const RegistrationSettings& pass : passes)
    check(pass, "registration", &RegistrationSettings::describe_pass);
  Cloud moving = source, fixed = target;
  for (const RegistrationSettings& pass : passes) {
    moving = prepared_source(std::move(moving), pass, Eigen::Vector3d::Zero());
    fixed = prepared_target(std::move(fixed), pass, Eigen::Vector3d::Zero());
  }
  const KdTreeTarget tree(std::move(fixed));
  RegistrationResult result;
  result.T_target_source = T_start;
  for (const RegistrationSettings& pass : passes)
    result = register_cloud(moving, tree, result.T_target_source, pass);
  return result;
}

std::vector<RegistrationSettings> wide_passes(MetricKind metric) {
  // From far, planes slide along each other, and a kernel takes the wrong half of the pairs for the right
  // one.
  RegistrationSettings coarse;
  coarse.selection = SelectionKind::uniform;
  coarse.selected_points = 500;
  coarse.metric = MetricKind::point_to_point;
  coarse.kernel = KernelKind::none;
  coarse.max_distance = 0.5;
  coarse.min_distance = 0.1;
  coarse.max_iterations = 40;
  coarse.epsilon_translation = 4e-3;
  coarse.epsilon_rotation = 2e-3;
  RegistrationSettings fine;
  fine.selection = SelectionKind::uniform;
  fine.selected_points = 1500;
  fine.metric = metric;
  fine.max_distance = 0.1;
  fine.degenerate_share =
      1e-3;  // without a prior, a weak direction is better followed than left at the start
  return {coarse, fine};
}

}  // namespace lcmslam

#include <lcmslam/dense_mapper/thesis/alternating.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr int fewest_features = 3;

/// One of the two sets of points: moves T on by some iterations.
class Turn {
 public:
  virtual ~Turn() = default;
  /// The transform after its iterations; nothing when there are too few pairs.
  virtual std::optional<Eigen::Isometry3d> take(const Eigen::Isometry3d& T) = 0;
  /// RMS distance (m) of the pairs at T; NaN without pairs.
  virtual double rms(const Eigen::Isometry3d& T) const = 0;
};

class NearestTurn : public Turn {
 public:
  NearestTurn(const Cloud& source, const Target& target, const RegistrationSettings& settings, int iterations)
      : source_(source), target_(target), settings_(settings) {
    settings_.max_iterations = iterations;
    settings_.epsilon_translation = settings_.epsilon_rotation = settings_.epsilon_rms = 0;
  }
  std::optional<Eigen::Isometry3d> take(const Eigen::Isometry3d& T) override {
    const RegistrationResult result = register_cloud(source_, target_, T, settings_);
    if (!result.ok()) return std::nullopt;
    // The adaptive limit lives on from turn to turn.
    const double next = settings_.distance_sigmas * result.rms.back();
    if (settings_.distance_sigmas > 0)
      settings_.max_distance =
          std::clamp(next, std::min(settings_.min_distance, settings_.max_distance), settings_.max_distance);
    return result.T_target_source;
  }
  double rms(const Eigen::Isometry3d& T) const override {
    RegistrationSettings look = settings_;
    look.max_iterations = 1;
    look.metric = MetricKind::point_to_point;
    const RegistrationResult result = register_cloud(source_, target_, T, look);
    return result.rms.empty() ? nan : result.rms.front();
  }

 private:
  const Cloud& source_;
  const Target& target_;
  RegistrationSettings settings_;
};

class FixedTurn : public Turn {
 public:
  FixedTurn(const FeaturePairs& features, const RegistrationSettings& settings, int iterations)
      : features_(features), solver_(make_solver(settings, nullptr)), iterations_(iterations) {}
  std::optional<Eigen::Isometry3d> take(const Eigen::Isometry3d& T) override {
    std::optional<Eigen::Isometry3d> result = T;
    for (int i = 0; i < iterations_ && result; ++i) result = solver_->solve(pairs(*result), *result);
    return result;
  }
  double rms(const Eigen::Isometry3d& T) const override {
    double sum = 0;
    for (const Pair& pair : pairs(T)) sum += pair.squared_distance();
    return std::sqrt(sum / static_cast<double>(features_.source.size()));  // NaN for none
  }

 private:
  std::vector<Pair> pairs(const Eigen::Isometry3d& T) const {
    std::vector<Pair> pairs(features_.source.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      pairs[i].source = features_.source[i].cast<double>();
      pairs[i].moved = T * pairs[i].source;
      pairs[i].target = features_.target[i].cast<double>();
    }
    return pairs;
  }

  const FeaturePairs& features_;
  std::unique_ptr<Solver> solver_;
  int iterations_;
};

void check(const FeaturePairs& features, const AlternatingSettings& s) {
  if (features.source.size() != features.target.size())
    throw std::invalid_argument("alternating ICP: " + std::to_string(features.source.size()) +
                                " source features, " + std::to_string(features.target.size()) +
                                " in the target");
  lcmslam::check(s, "alternating ICP");
  if (s.registration.metric != MetricKind::point_to_point)
    throw std::invalid_argument("alternating ICP: the metric must be point to point");
}

RegistrationSettings feature_settings(RegistrationSettings settings) {
  settings.selection = SelectionKind::all;
  settings.min_pairs = fewest_features;
  return settings;
}

}  // namespace

AlternatingSettings::AlternatingSettings() {
  registration.metric = MetricKind::point_to_point;
  registration.solver = SolverKind::svd;
  registration.kernel = KernelKind::none;
  registration.weigh_by_noise = false;
  registration.max_distance = 10;
  registration.distance_sigmas = 0;
  registration.max_normal_angle = 3.2;
}

std::optional<Eigen::Isometry3d> align_start(const FeaturePairs& features,
                                             const RegistrationSettings& settings) {
  // The closed forms are there after one iteration; small angles are a linear step that is taken again.
  constexpr int most = 50;
  constexpr double still = 1e-9;  // m and rad
  FixedTurn turn(features, settings, 1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < most; ++i) {
    const auto next = turn.take(T);
    if (!next) return std::nullopt;
    const bool done = distance_between(*next, T) < still && angle_between(*next, T) < still;
    T = *next;
    if (done) break;
  }
  return T;
}

AlternatingResult register_alternating(const Cloud& overlap, const Target& target,
                                       const FeaturePairs& features, const Eigen::Isometry3d& T_start,
                                       const AlternatingSettings& settings) {
  check(features, settings);
  const Cloud source_features{features.source, {}, {}};
  const KdTreeTarget target_features(Cloud{features.target, {}, {}});
  NearestTurn cloud_turn(overlap, target, settings.registration, settings.cloud_iterations);
  const RegistrationSettings of_features = feature_settings(settings.registration);
  NearestTurn nearest_turn(source_features, target_features, of_features, settings.feature_iterations);
  FixedTurn fixed_turn(features, of_features, settings.feature_iterations);
  const bool fixed = settings.pairing == FeaturePairing::fixed;
  Turn& feature_turn = fixed ? static_cast<Turn&>(fixed_turn) : nearest_turn;

  AlternatingResult result;
  Eigen::Isometry3d T = T_start;
  double last_error = std::numeric_limits<double>::infinity();
  for (int round = 0; round < settings.max_rounds; ++round) {
    const auto after_cloud = settings.cloud_iterations > 0 ? cloud_turn.take(T) : std::nullopt;
    const Eigen::Isometry3d T_cloud = after_cloud.value_or(T);
    const auto after_features = settings.feature_iterations > 0 ? feature_turn.take(T_cloud) : std::nullopt;
    const Eigen::Isometry3d T_features = after_features.value_or(T_cloud);
    if (!after_cloud && !after_features) break;

    const double cloud_error = after_cloud ? cloud_turn.rms(T_cloud) : nan;
    const double feature_error = after_features ? feature_turn.rms(T_features) : nan;
    result.cloud_rms.push_back(cloud_error);
    result.feature_rms.push_back(feature_error);
    result.from_features = !(cloud_error <= feature_error) && std::isfinite(feature_error);
    result.T_target_source = result.from_features ? T_features : T_cloud;
    T = T_features;

    const double error = result.from_features ? feature_error : cloud_error;
    result.stop = StopReason::max_iterations;
    if (std::abs(last_error - error) < settings.epsilon_rms) {
      result.stop = StopReason::converged;
      break;
    }
    last_error = error;
  }
  return result;
}

}  // namespace lcmslam

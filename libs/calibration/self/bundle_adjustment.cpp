#include <lcmslam/calibration/self/bundle_adjustment.hpp>

#include <cmath>

#include <lcmslam/calibration/self/bundle_problem.hpp>
#include <lcmslam/calibration/self/observability.hpp>
#include <lcmslam/calibration/self/rolling_shutter.hpp>

namespace lcmslam {
namespace {

constexpr double come_and_go = 0.02;  // of the sightings; what compares others has not converged

bool differ(const HeadNumbers& a, const HeadNumbers& b, const HeadNumbers& by) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(a[i] - b[i]) > by[i]) return true;
  return false;
}

/// What nothing was compared to stays as sure as it was; nothing is surer than what no residual shows.
void tell_covariance(const BundleProblem::HeadCovariance& of_head, const HeadNumbers& priors,
                     const HeadNumbers& unmodelled, BundleResult& result) {
  result.priors = result.sigmas = priors;
  result.covariance = Eigen::MatrixXd::Zero(head::count, head::count);
  for (std::size_t i = 0; i < priors.size(); ++i)
    result.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = priors[i] * priors[i];
  for (std::size_t i = 0; i < of_head.parameters.size(); ++i) {
    const std::size_t parameter = of_head.parameters[i];
    const auto row = static_cast<Eigen::Index>(parameter);
    for (std::size_t k = 0; k < of_head.parameters.size(); ++k)
      result.covariance(row, static_cast<Eigen::Index>(of_head.parameters[k])) =
          of_head.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    result.covariance(row, row) += unmodelled[parameter] * unmodelled[parameter];
    result.sigmas[parameter] = std::sqrt(result.covariance(row, row));
  }
}

}  // namespace

BundleResult adjust_bundle(HeadModel& model, SceneObservations& scene, const CalibrationPriors& priors,
                           const BundleSettings& settings) {
  const BundlePriors told(priors, model);
  const HeadNumbers unmodelled = unmodelled_sigmas(model.start);
  HeadNumbers still = unmodelled;  // what moves by less has converged
  for (double& step : still) step *= settings.converged;
  BundleState state(model, scene);
  BundleResult result;
  Comparisons seen = compare(state, settings, nullptr);
  for (bool moves = true; moves && result.rounds < settings.rounds; ++result.rounds) {
    const HeadNumbers before = model.values;
    BundleProblem(state, seen, told, settings).solve();
    state.take_over();
    const int compared = seen.pixels;
    seen = compare(state, settings, &seen);
    moves = differ(model.values, before, still) || std::abs(seen.pixels - compared) > come_and_go * compared;
  }
  result.pixels = seen.pixels;
  result.depths = seen.depths;
  result.pixel_scale = seen.pixel_scale;
  result.depth_scale = seen.depth_scale;
  tell_covariance(BundleProblem(state, seen, told, settings).head_covariance(), told.sigmas, unmodelled,
                  result);
  result.unobserved_directions = unobserved_directions(result, settings.unobserved);
  return result;
}

HeadModel observed_head(const HeadModel& model, const BundleResult& result, const BundleSettings& settings) {
  HeadModel head = model;
  const HeadModel start(model.start);
  for (int i = 0; i < head::count; ++i)
    if (!is_observed(result, static_cast<head::Parameter>(i), settings))
      head.values[static_cast<std::size_t>(i)] = start.values[static_cast<std::size_t>(i)];
  head.values[head::colour_rows] = head.values[head::depth_rows] =
      rolling_shutter_of(model, result, settings).seconds;
  return head;
}

}  // namespace lcmslam

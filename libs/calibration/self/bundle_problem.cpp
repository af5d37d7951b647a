#include <lcmslam/calibration/self/bundle_problem.hpp>

#include <ceres/ceres.h>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/calibration/self/cost_functions.hpp>
#include <lcmslam/calibration/self/marginal_covariance.hpp>

namespace lcmslam {
namespace {

constexpr double kernel_sigmas = 2;  // beyond them a residual counts less

/// The head's numbers as blocks of the problem.
struct Block {
  int first, size;
  double* of(HeadModel& model) const { return model.values.data() + first; }
};
constexpr Block intrinsics_block{head::fx, 9}, extrinsics_block{head::tx, 6},
    depth_block{head::depth_scale, 6}, rows_block{head::colour_rows, 1};
constexpr Block head_blocks[] = {intrinsics_block, extrinsics_block, depth_block, rows_block};

}  // namespace

BundleProblem::BundleProblem(BundleState& state, const Comparisons& comparisons, const BundlePriors& priors,
                             const BundleSettings& settings)
    : state_(state), comparisons_(comparisons), priors_(priors), settings_(settings) {
  for (const Comparison& c : comparisons.all) add(c);
  add_priors();
  add_curve_priors();
  // The first keyframe that is compared to anything is the world.
  bool world = true;
  for (std::size_t k = 0; k < state_.moved.size(); ++k) {
    if (!problem_.HasParameterBlock(state_.moved[k].data())) continue;
    add_keyframe(k, world);
    world = false;
  }
}

// With a global shutter a turn rate moves nothing but depth, by a few milliseconds: it would follow noise.
void BundleProblem::add_keyframe(std::size_t k, bool is_world) {
  constexpr double rolls = 0.005;  // s, from the first row to the last
  double* keyframe = state_.moved[k].data();
  const ObservedKeyframe& observed = state_.scene.keyframes[k];
  const bool turns = observed.turn_noise > 0 && std::abs(state_.model.values[head::colour_rows]) > rolls;
  std::vector<int> held;
  for (int i = 0; i < residuals::keyframe_size; ++i)
    if (i < residuals::turn_rate_at ? is_world : !turns) held.push_back(i);
  if (static_cast<int>(held.size()) == residuals::keyframe_size)
    problem_.SetParameterBlockConstant(keyframe);
  else if (!held.empty())
    problem_.SetManifold(keyframe, new ceres::SubsetManifold(residuals::keyframe_size, held));
  if (!turns) return;
  const Eigen::Vector3d told = (state_.told_twists[k] - observed.twist).tail<3>();
  problem_.AddResidualBlock(cost_of(residuals::ToldTurnRate{told, observed.turn_noise}), nullptr, keyframe);
}

void BundleProblem::add(const Comparison& c) {
  const double width = kernel_sigmas / settings_.correlation;
  HeadModel& model = state_.model;
  double* keyframe = state_.moved[c.keyframe].data();
  double* point = state_.scene.landmarks[c.landmark].point.data();
  residuals::Reprojection pixel = c.pixel;
  pixel.sigma *= comparisons_.pixel_scale * settings_.correlation;
  problem_.AddResidualBlock(cost_of(pixel), new ceres::CauchyLoss(width), keyframe, point,
                            intrinsics_block.of(model), rows_block.of(model));
  if (!c.patch) return;
  double* curve = state_.curve.values.data() + c.range.first;
  auto* loss = new ceres::CauchyLoss(width);
  if (model.registered())
    problem_.AddResidualBlock(cost_of(surface_of_colour(c)), loss, keyframe, point,
                              intrinsics_block.of(model), depth_block.of(model), curve, curve + 1, curve + 2,
                              curve + 3);
  else
    problem_.AddResidualBlock(cost_of(surface_of_own_camera(c)), loss, keyframe, point,
                              extrinsics_block.of(model), depth_block.of(model), curve, curve + 1, curve + 2,
                              curve + 3);
}

residuals::Patch BundleProblem::weighed(residuals::Patch patch) const {
  patch.sigma *= comparisons_.depth_scale * settings_.correlation;
  return patch;
}

residuals::SurfaceOfColour BundleProblem::surface_of_colour(const Comparison& c) const {
  residuals::SurfaceOfColour surface{c.pixel.T_start, c.pixel.twist,     {},     c.lag,
                                     c.row,           weighed(*c.patch), c.range};
  std::copy(state_.rational, state_.rational + 3, surface.rational);
  return surface;
}

residuals::SurfaceOfOwnCamera BundleProblem::surface_of_own_camera(const Comparison& c) const {
  const CameraModel& d = state_.model.start.depth;
  residuals::SurfaceOfOwnCamera surface{c.pixel.T_start,
                                        state_.model.start.T_colour_depth,
                                        c.pixel.twist,
                                        {d.fx, d.fy, d.cx, d.cy},
                                        {},
                                        {},
                                        c.lag,
                                        c.row,
                                        weighed(*c.patch),
                                        c.range};
  for (std::size_t i = 0; i < d.distortion.size(); ++i)
    (i < 5 ? surface.lens[i] : surface.rational[i - 5]) = d.distortion[i];
  return surface;
}

/// Held numbers leave their block.
void BundleProblem::add_priors() {
  for (const Block& block : head_blocks) {
    double* values = block.of(state_.model);
    if (!problem_.HasParameterBlock(values)) continue;
    std::vector<int> held;
    for (int i = 0; i < block.size; ++i) {
      const auto p = static_cast<std::size_t>(block.first + i);
      if (priors_.sigmas[p] > 0)
        problem_.AddResidualBlock(
            cost_of(residuals::Prior{i, priors_.values[p], priors_.sigmas[p]}, block.size), nullptr, values);
      else
        held.push_back(i);
    }
    if (static_cast<int>(held.size()) == block.size)
      problem_.SetParameterBlockConstant(values);
    else if (!held.empty())
      problem_.SetManifold(values, new ceres::SubsetManifold(block.size, held));
  }
  constexpr double one_focal_length = 1e-5;
  if (priors_.sigmas[head::fx] > 0)
    problem_.AddResidualBlock(cost_of(residuals::Aspect{priors_.values[head::fx] / priors_.values[head::fy],
                                                        std::max(one_focal_length, priors_.aspect)}),
                              nullptr, intrinsics_block.of(state_.model));
}

// What errs alike in all images is as large as the calibration's noise of one pixel, which counts it.
void BundleProblem::add_curve_priors() {
  constexpr double mixed = 1.6;  // a number's sigma over the curve's, which is a mean of four
  const RgbdCalibration& start = state_.model.start;
  RangeCurve& curve = state_.curve;
  for (std::size_t i = 0; i < curve.values.size(); ++i) {
    double* value = &curve.values[i];
    if (!problem_.HasParameterBlock(value)) continue;
    const double range = std::max(start.depth_min, curve.range_of(static_cast<int>(i)));
    const double sigma = priors_.range_curve * mixed * start.depth_noise.sigma(range);
    if (sigma > 0)
      problem_.AddResidualBlock(cost_of(residuals::Prior{0, 0, sigma}, 1), nullptr, value);
    else
      problem_.SetParameterBlockConstant(value);
  }
}

std::vector<double*> BundleProblem::used_landmarks() const {
  std::vector<double*> blocks;
  for (auto& landmark : state_.scene.landmarks)
    if (problem_.HasParameterBlock(landmark.point.data())) blocks.push_back(landmark.point.data());
  return blocks;
}

void BundleProblem::solve() {
  ceres::Solver::Options options;
  options.num_threads = 1;  // the same result everywhere
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = settings_.iterations;
  options.function_tolerance = 1e-7;
  // Nearly Gauss and Newton's steps: head and scene move together along weak directions, which damping by
  // the strong ones would hold.
  options.initial_trust_region_radius = 1e6;
  options.logging_type = ceres::SILENT;
  // A group for each kind: in a group Ceres goes by addresses, and which array lies before which differs from
  // run to run.
  auto* order = new ceres::ParameterBlockOrdering;
  const auto add = [&](double* block, int group) {
    if (problem_.HasParameterBlock(block)) order->AddElementToGroup(block, group);
  };
  for (double* landmark : used_landmarks()) add(landmark, 0);
  for (auto& keyframe : state_.moved) add(keyframe.data(), 1);
  for (const Block& block : head_blocks) add(block.of(state_.model), 2);
  for (double& value : state_.curve.values) add(&value, 3);
  options.linear_solver_ordering.reset(order);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  if (!summary.IsSolutionUsable()) throw std::runtime_error("self calibration: " + summary.message);
}

bool BundleProblem::is_moved(double* block) const {
  return problem_.HasParameterBlock(block) && !problem_.IsParameterBlockConstant(block);
}

BundleProblem::HeadCovariance BundleProblem::head_covariance() {
  HeadCovariance result;
  std::vector<double*> blocks, others;
  for (const Block& block : head_blocks) {
    double* values = block.of(state_.model);
    if (!is_moved(values)) continue;
    blocks.push_back(values);
    for (int i = 0; i < block.size; ++i)
      if (priors_.sigmas[static_cast<std::size_t>(block.first + i)] > 0)
        result.parameters.push_back(static_cast<std::size_t>(block.first + i));
  }
  for (auto& keyframe : state_.moved)
    if (is_moved(keyframe.data())) others.push_back(keyframe.data());
  for (double& value : state_.curve.values)
    if (is_moved(&value)) others.push_back(&value);
  if (!blocks.empty()) result.covariance = marginal_covariance(problem_, blocks, others, used_landmarks());
  return result;
}

}  // namespace lcmslam

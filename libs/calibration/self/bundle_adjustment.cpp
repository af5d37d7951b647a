#include <lcmslam/calibration/self/bundle_adjustment.hpp>

#include <ceres/ceres.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include <lcmslam/calibration/self/cost_functions.hpp>
#include <lcmslam/calibration/self/depth_patch.hpp>
#include <lcmslam/calibration/self/marginal_covariance.hpp>
#include <lcmslam/calibration/self/observability.hpp>
#include <lcmslam/calibration/self/range_curve.hpp>
#include <lcmslam/calibration/self/residuals.hpp>
#include <lcmslam/calibration/self/velocity_scale.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_pixels = 100;
// Far off: a robust weight is enough nearer by, and gates that follow the scale of what they let through
// would close on whatever the first rounds liked.
constexpr double outlier_sigmas = 20;  // of the scale that was seen
constexpr double kernel_sigmas = 2;    // beyond them a residual counts less
constexpr double least_pixel = 0.05;   // pixels and shares of depth's noise: scales below are none
constexpr double least_depth = 0.05;
constexpr double near_gate = 4,
                 near_depth_gate = 2;  // pixels, shares of depth's noise: nothing nearer is an outlier

/// The head's numbers as blocks of the problem.
struct Block {
  int first, size;
};
constexpr Block intrinsics_block{head::fx, 9}, extrinsics_block{head::tx, 6},
    depth_block{head::depth_scale, 6}, rows_block{head::colour_rows, 1};
constexpr Block head_blocks[] = {intrinsics_block, extrinsics_block, depth_block, rows_block};

struct Scales {
  double pixel, depth;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A sighting with what it is compared to.
struct Comparison {
  int keyframe;
  std::size_t landmark;
  residuals::Reprojection pixel;
  std::optional<residuals::Patch> patch;
  RangeCurve::Place range;  // as measured there
  double lag, row;          // of depth
};

class Adjustment {
 public:
  Adjustment(HeadModel& model, SceneObservations& scene, const CalibrationPriors& priors,
             const BundleSettings& settings)
      : model_(model),
        scene_(scene),
        settings_(settings),
        prior_sigmas_(priors.sigmas(model.start)),
        prior_values_(model.values),
        aspect_sigma_(priors.aspect),
        curve_(model.start.depth_max),
        curve_share_(priors.range_curve) {
    for (const ObservedKeyframe& keyframe : scene.keyframes) {
      starts_.push_back(keyframe.T_world_camera.inverse());
      told_twists_.push_back(keyframe.twist);
      poses_.push_back({});
    }
    const auto& d = model.start.colour.distortion;
    if (d.size() == 8) std::copy(d.begin() + 5, d.end(), rational_);
  }

  BundleResult run() {
    for (int round = 0; round < settings_.rounds; ++round) {
      const HeadNumbers before = model_.values;
      compare(round);
      build();
      solve();
      take_over();
      ++result_.rounds;
      if (!moved_since(before)) break;
    }
    compare(result_.rounds);
    build();
    return conclude();
  }

 private:
  bool moved_since(const HeadNumbers& before) const {
    const HeadNumbers unmodelled = unmodelled_sigmas(model_.start);
    for (std::size_t i = 0; i < before.size(); ++i)
      if (std::abs(model_.values[i] - before[i]) > settings_.converged * unmodelled[i]) return true;
    return false;
  }

  Eigen::Vector3d seen_by_colour(const Comparison& c, double seconds) const {
    const auto k = static_cast<std::size_t>(c.keyframe);
    const double none[6] = {};
    return residuals::in_camera(starts_[k], scene_.keyframes[k].twist, none,
                                scene_.landmarks[c.landmark].point.data(), seconds);
  }

  /// What each sighting is compared to, by the present values; scales follow from what is left over.
  void compare(int round) {
    comparisons_.clear();
    const CameraModel depth_camera = model_.depth();
    const Eigen::Isometry3d T_depth_colour = model_.T_colour_depth().inverse();
    const HeadNumbers& h = model_.values;
    std::vector<double> pixel_errors, depth_errors;
    std::vector<std::array<double, 2>> errors;
    for (std::size_t l = 0; l < scene_.landmarks.size(); ++l)
      for (const LandmarkSighting& sighting : scene_.landmarks[l].sightings) {
        const auto k = static_cast<std::size_t>(sighting.keyframe);
        const ObservedKeyframe& keyframe = scene_.keyframes[k];
        Comparison c;
        c.keyframe = sighting.keyframe;
        c.landmark = l;
        c.pixel.T_start = starts_[k];
        c.pixel.twist = keyframe.twist;
        c.pixel.pixel = sighting.pixel;
        c.pixel.row = (sighting.pixel.y() + 0.5) / model_.start.colour.height - 0.5;
        std::copy(rational_, rational_ + 3, c.pixel.rational);
        c.pixel.sigma = sighting.sigma;
        double seen[2];
        if (!residuals::project(h.data() + head::fx, rational_,
                                seen_by_colour(c, c.pixel.row * h[head::colour_rows]), seen))
          continue;
        const double error = (Eigen::Vector2d(seen[0], seen[1]) - sighting.pixel).norm();
        if (error > (round == 0 ? settings_.pixel_gate
                                : std::max(near_gate, outlier_sigmas * scales_.pixel) * sighting.sigma))
          continue;
        pixel_errors.push_back(error / sighting.sigma);

        // The row is that of the pixel where the landmark lies in the depth image: two looks find it.
        c.lag = keyframe.depth_lag;
        c.row = 0;
        std::optional<Eigen::Vector2d> pixel;
        Eigen::Vector3d p;
        for (int look = 0; look < 2; ++look) {
          p = T_depth_colour * seen_by_colour(c, c.lag + h[head::depth_clock] + c.row * h[head::depth_rows]);
          pixel = depth_camera.project(p);
          if (!pixel) break;
          c.row = std::clamp((pixel->y() + 0.5) / depth_camera.height - 0.5, -0.5, 0.5);
        }
        double depth_error = 0;
        if (pixel && !keyframe.inverse_depth.empty())
          c.patch = depth_patch(keyframe.inverse_depth, *pixel, depth_camera, model_.start.depth_noise);
        if (c.patch) {
          c.range = curve_.place(depth_camera.ray(*pixel).norm() / c.patch->inverse);
          depth_error = residuals::depth_error<double>(*c.patch, pixel->data(), p,
                                                       h.data() + head::depth_scale, curve_.at(c.range));
          const double gate =
              round == 0 ? settings_.depth_gate / c.patch->sigma : outlier_sigmas * scales_.depth;
          if (std::abs(depth_error) < std::max(near_depth_gate, gate))
            depth_errors.push_back(std::abs(depth_error));
          else
            c.patch.reset();
        }
        comparisons_.push_back(c);
      }
    if (comparisons_.size() < fewest_pixels)
      throw std::runtime_error("self calibration: only " + std::to_string(comparisons_.size()) +
                               " sightings of landmarks agree with their keyframes; at least " +
                               std::to_string(fewest_pixels) + " are needed");
    // Of the length of two normal numbers the median is 1.1774 sigma, of one's absolute value 0.6745.
    scales_.pixel = std::max(least_pixel, median(pixel_errors) / 1.1774);
    scales_.depth = depth_errors.empty() ? 1 : std::max(least_depth, median(depth_errors) / 0.6745);
    result_.pixels = static_cast<int>(pixel_errors.size());
    result_.depths = static_cast<int>(depth_errors.size());
    result_.pixel_scale = scales_.pixel;
    result_.depth_scale = scales_.depth;
  }

  void build() {
    problem_ = std::make_unique<ceres::Problem>();
    const double width = kernel_sigmas / settings_.correlation;
    double* intrinsics = model_.values.data() + head::fx;
    double* extrinsics = model_.values.data() + head::tx;
    double* depth = model_.values.data() + head::depth_scale;
    double* rows = model_.values.data() + head::colour_rows;
    for (const Comparison& c : comparisons_) {
      double* pose = poses_[static_cast<std::size_t>(c.keyframe)].data();
      double* point = scene_.landmarks[c.landmark].point.data();
      residuals::Reprojection pixel = c.pixel;
      pixel.sigma *= scales_.pixel * settings_.correlation;
      problem_->AddResidualBlock(cost_of(pixel), new ceres::CauchyLoss(width), pose, point, intrinsics, rows);
      if (!c.patch) continue;
      double* curve = curve_.values.data() + c.range.first;
      auto* loss = new ceres::CauchyLoss(width);
      if (model_.registered())
        problem_->AddResidualBlock(cost_of(surface_of_colour(c)), loss, pose, point, intrinsics, depth, curve,
                                   curve + 1, curve + 2, curve + 3);
      else
        problem_->AddResidualBlock(cost_of(surface_of_own_camera(c)), loss, pose, point, extrinsics, depth,
                                   curve, curve + 1, curve + 2, curve + 3);
    }
    add_priors();
    add_curve_priors();
    // The first keyframe that is compared to anything is the world.
    for (auto& pose : poses_)
      if (problem_->HasParameterBlock(pose.data())) {
        problem_->SetParameterBlockConstant(pose.data());
        break;
      }
  }

  residuals::Patch weighed(residuals::Patch patch) const {
    patch.sigma *= scales_.depth * settings_.correlation;
    return patch;
  }

  residuals::SurfaceOfColour surface_of_colour(const Comparison& c) const {
    residuals::SurfaceOfColour surface{c.pixel.T_start, c.pixel.twist,     {},     c.lag,
                                       c.row,           weighed(*c.patch), c.range};
    std::copy(rational_, rational_ + 3, surface.rational);
    return surface;
  }

  residuals::SurfaceOfOwnCamera surface_of_own_camera(const Comparison& c) const {
    const CameraModel& d = model_.start.depth;
    residuals::SurfaceOfOwnCamera surface{
        c.pixel.T_start, model_.start.T_colour_depth, c.pixel.twist, {d.fx, d.fy, d.cx, d.cy}, {}, {}, c.lag,
        c.row,           weighed(*c.patch),           c.range};
    for (std::size_t i = 0; i < d.distortion.size(); ++i)
      (i < 5 ? surface.lens[i] : surface.rational[i - 5]) = d.distortion[i];
    return surface;
  }

  /// Held numbers leave their block.
  void add_priors() {
    for (const Block& block : head_blocks) {
      double* values = model_.values.data() + block.first;
      if (!problem_->HasParameterBlock(values)) continue;
      std::vector<int> held;
      for (int i = 0; i < block.size; ++i) {
        const auto p = static_cast<std::size_t>(block.first + i);
        if (prior_sigmas_[p] > 0)
          problem_->AddResidualBlock(
              cost_of(residuals::Prior{i, prior_values_[p], prior_sigmas_[p]}, block.size), nullptr, values);
        else
          held.push_back(i);
      }
      if (static_cast<int>(held.size()) == block.size)
        problem_->SetParameterBlockConstant(values);
      else if (!held.empty())
        problem_->SetManifold(values, new ceres::SubsetManifold(block.size, held));
    }
    constexpr double one_focal_length = 1e-5;
    if (prior_sigmas_[head::fx] > 0)
      problem_->AddResidualBlock(cost_of(residuals::Aspect{prior_values_[head::fx] / prior_values_[head::fy],
                                                           std::max(one_focal_length, aspect_sigma_)}),
                                 nullptr, model_.values.data() + head::fx);
  }

  // What errs alike in all images is as large as the calibration's noise of one pixel, which counts it.
  void add_curve_priors() {
    constexpr double mixed = 1.6;  // a number's sigma over the curve's, which is a mean of four
    for (std::size_t i = 0; i < curve_.values.size(); ++i) {
      double* value = &curve_.values[i];
      if (!problem_->HasParameterBlock(value)) continue;
      const double range = std::max(model_.start.depth_min, curve_.range_of(static_cast<int>(i)));
      const double sigma = curve_share_ * mixed * model_.start.depth_noise.sigma(range);
      if (sigma > 0)
        problem_->AddResidualBlock(cost_of(residuals::Prior{0, 0, sigma}, 1), nullptr, value);
      else
        problem_->SetParameterBlockConstant(value);
    }
  }

  std::vector<double*> used_landmarks() {
    std::vector<double*> blocks;
    for (auto& landmark : scene_.landmarks)
      if (problem_->HasParameterBlock(landmark.point.data())) blocks.push_back(landmark.point.data());
    return blocks;
  }

  void solve() {
    ceres::Solver::Options options;
    options.num_threads = 1;  // the same result everywhere
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = settings_.iterations;
    options.function_tolerance = 1e-7;
    // Nearly Gauss and Newton's steps: head and scene move together along weak directions, which damping by
    // the strong ones would hold.
    options.initial_trust_region_radius = 1e6;
    options.logging_type = ceres::SILENT;
    auto* order = new ceres::ParameterBlockOrdering;
    for (double* landmark : used_landmarks()) order->AddElementToGroup(landmark, 0);
    for (auto& pose : poses_)
      if (problem_->HasParameterBlock(pose.data())) order->AddElementToGroup(pose.data(), 1);
    for (const Block& block : head_blocks)
      if (problem_->HasParameterBlock(model_.values.data() + block.first))
        order->AddElementToGroup(model_.values.data() + block.first, 1);
    for (double& value : curve_.values)
      if (problem_->HasParameterBlock(&value)) order->AddElementToGroup(&value, 1);
    options.linear_solver_ordering.reset(order);
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    if (!summary.IsSolutionUsable()) throw std::runtime_error("self calibration: " + summary.message);
  }

  /// Poses begin anew where the solution put them, and velocities follow them.
  void take_over() {
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
      moved.linear() = so3_exp(Eigen::Vector3d(poses_[k].data()));
      moved.translation() = Eigen::Vector3d(poses_[k].data() + 3);
      starts_[k] = moved * starts_[k];
      scene_.keyframes[k].T_world_camera = starts_[k].inverse();
      poses_[k] = {};
    }
    const VelocityScale scale = velocity_scale(scene_.keyframes);
    for (std::size_t k = 0; k < told_twists_.size(); ++k)
      scene_.keyframes[k].twist << scale.translation * told_twists_[k].head<3>(),
          scale.rotation * told_twists_[k].tail<3>();
  }

  BundleResult conclude() {
    std::vector<double*> blocks, others;
    std::vector<std::size_t> parameters;  // of the covariance's rows
    for (const Block& block : head_blocks) {
      double* values = model_.values.data() + block.first;
      if (!problem_->HasParameterBlock(values) || problem_->IsParameterBlockConstant(values)) continue;
      blocks.push_back(values);
      for (int i = 0; i < block.size; ++i)
        if (prior_sigmas_[static_cast<std::size_t>(block.first + i)] > 0)
          parameters.push_back(static_cast<std::size_t>(block.first + i));
    }
    for (auto& pose : poses_)
      if (problem_->HasParameterBlock(pose.data()) && !problem_->IsParameterBlockConstant(pose.data()))
        others.push_back(pose.data());
    for (double& value : curve_.values)
      if (problem_->HasParameterBlock(&value) && !problem_->IsParameterBlockConstant(&value))
        others.push_back(&value);
    Eigen::MatrixXd covariance;
    if (!blocks.empty()) covariance = marginal_covariance(*problem_, blocks, others, used_landmarks());

    result_.priors = prior_sigmas_;
    result_.sigmas = prior_sigmas_;  // what nothing was compared to stays as sure as it was
    result_.covariance = Eigen::MatrixXd::Zero(head::count, head::count);
    for (std::size_t i = 0; i < prior_sigmas_.size(); ++i)
      result_.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) =
          prior_sigmas_[i] * prior_sigmas_[i];
    const HeadNumbers unmodelled = unmodelled_sigmas(model_.start);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(parameters[i]);
      for (std::size_t k = 0; k < parameters.size(); ++k)
        result_.covariance(row, static_cast<Eigen::Index>(parameters[k])) =
            covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      const double u = unmodelled[parameters[i]];
      result_.covariance(row, row) += u * u;
      result_.sigmas[parameters[i]] = std::sqrt(result_.covariance(row, row));
    }
    result_.unobserved_directions = unobserved_directions(result_, settings_.unobserved);
    return result_;
  }

  HeadModel& model_;
  SceneObservations& scene_;
  BundleSettings settings_;
  HeadNumbers prior_sigmas_, prior_values_;
  double aspect_sigma_;
  RangeCurve curve_;
  double curve_share_;
  double rational_[3] = {};
  std::vector<Eigen::Isometry3d> starts_;     // T_camera_world
  std::vector<Vector6d> told_twists_;         // as they were at first
  std::vector<std::array<double, 6>> poses_;  // what they have moved since
  std::vector<Comparison> comparisons_;
  Scales scales_{1, 1};
  std::unique_ptr<ceres::Problem> problem_;
  BundleResult result_;
};

}  // namespace

BundleResult adjust_bundle(HeadModel& model, SceneObservations& scene, const CalibrationPriors& priors,
                           const BundleSettings& settings) {
  return Adjustment(model, scene, priors, settings).run();
}

HeadModel observed_head(const HeadModel& model, const BundleResult& result, const BundleSettings& settings) {
  HeadModel head = model;
  const HeadModel start(model.start);
  for (int i = 0; i < head::count; ++i)
    if (!is_observed(result, static_cast<head::Parameter>(i), settings))
      head.values[static_cast<std::size_t>(i)] = start.values[static_cast<std::size_t>(i)];
  return head;
}

}  // namespace lcmslam

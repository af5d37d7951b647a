#include <lcmslam/fastslam/smoothing/map_smoother.hpp>

#include <ceres/ceres.h>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/smoothing/map_factors.hpp>

namespace lcmslam {
namespace {

constexpr int visits_kept = 2;          // of a place: the second one closes the loop, a third says little new
constexpr double thinner = 1.41421356;  // a step of the spacing; halves the keyframes of an area
constexpr int maximum_iterations = 15;

bool near(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B, double spacing) {
  const Eigen::Isometry3d way = A.inverse() * B;
  return way.translation().norm() < spacing && rotation_angle(way) < spacing;
}

using Vector6 = std::array<double, 6>;

Motion chained(const Motion& first, const Motion& second) {
  const Matrix6d A = adjoint(second.T_from_to.inverse());
  Motion both = second;
  both.T_from_to = first.T_from_to * second.T_from_to;
  both.covariance = A * first.covariance * A.transpose() + second.covariance;
  return both;
}

}  // namespace

void MapSmoother::add(Utime utime, const Eigen::Isometry3d& T_world_robot,
                      const std::optional<Motion>& motion, const std::vector<PointObservation>& seen,
                      bool loop_closed) {
  loop_closed_ = loop_closed_ || loop_closed;
  if (!keyframes_.empty() && motion && motion_)
    motion_ = chained(*motion_, *motion);
  else
    motion_.reset();  // for good until the next keyframe
  if (!keyframes_.empty() && near(keyframes_.back().T_world_robot, T_world_robot, spacing_)) return;
  if (seen.empty() || (!loop_closed_ && known_from(T_world_robot))) return;
  keyframes_.push_back({utime, T_world_robot, motion_, seen, loop_closed_});
  motion_ = Motion();
  loop_closed_ = false;
  while (keyframes_.size() > maximum_keyframes) thin();
}

bool MapSmoother::known_from(const Eigen::Isometry3d& T_world_robot) const {
  return std::count_if(keyframes_.begin(), keyframes_.end(), [&](const Keyframe& k) {
           return near(k.T_world_robot, T_world_robot, spacing_);
         }) >= visits_kept;
}

// Fewer keyframes for the same way: those go that stand nearer to the one before than the wider spacing, or
// where others stand already. Their motions stay, and that they closed a loop says the next one.
void MapSmoother::thin() {
  spacing_ *= thinner;
  std::vector<Keyframe> all = std::exchange(keyframes_, {});
  std::optional<Motion> motion = Motion();  // since the last one that was kept
  bool closed = false;                      // by one that went, since then
  for (Keyframe& k : all) {
    motion = motion && k.motion ? std::optional(chained(*motion, *k.motion)) : std::nullopt;
    const bool first = keyframes_.empty();
    closed = closed || k.loop_closed;
    const bool useless = !first && (near(keyframes_.back().T_world_robot, k.T_world_robot, spacing_) ||
                                    (!closed && known_from(k.T_world_robot)));
    if (useless) continue;
    k.motion = motion;
    k.loop_closed = std::exchange(closed, false);
    if (first) k.motion.reset();
    keyframes_.push_back(std::move(k));
    motion = Motion();
  }
  loop_closed_ = loop_closed_ || closed;
  motion_ = motion && motion_ ? std::optional(chained(*motion, *motion_)) : std::nullopt;
}

// Where the search starts. A closed loop's error is more than a linearisation bears: it is first shared out
// over the motions since what is recognised was last seen, to each by its variance, and all between moves by
// its part of the whole correction (trajectory bending: Dubbelman and Browning 2015).
std::vector<Eigen::Isometry3d> MapSmoother::deformed_path() const {
  std::vector<Eigen::Isometry3d> path;
  std::map<std::int64_t, std::size_t> last_seen;  // keyframe
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    const Keyframe& k = keyframes_[i];
    path.push_back(k.T_world_robot);
    if (k.loop_closed && k.motion && i > 0) {
      std::size_t from = 0;
      for (const PointObservation& s : k.seen)
        if (const auto found = last_seen.find(s.landmark); found != last_seen.end())
          from = std::max(from, found->second);
      std::vector<double> share(i + 1, 0);  // summed from there
      for (std::size_t j = from + 1; j <= i; ++j)
        share[j] = share[j - 1] + (keyframes_[j].motion ? keyframes_[j].motion->covariance.trace() : 1.0);
      const Eigen::Isometry3d T_drifted = path[i - 1] * k.motion->T_from_to;
      const Vector6d correction = se3_log(k.T_world_robot * T_drifted.inverse());
      for (std::size_t j = from + 1; j < i; ++j)
        path[j] = se3_exp(Vector6d(share[j] / share[i] * correction)) * path[j];
    }
    for (const PointObservation& s : k.seen) last_seen[s.landmark] = i;
  }
  return path;
}

void MapSmoother::take_over(const MapSmoothing& smoothed) {
  auto pose = smoothed.path.begin();
  for (Keyframe& k : keyframes_) {
    while (pose != smoothed.path.end() && pose->utime < k.utime) ++pose;
    k.T_world_robot =
        pose != smoothed.path.end() ? pose->T_world_robot : smoothed.T_world_correction * k.T_world_robot;
  }
}

std::optional<MapSmoothing> MapSmoother::solve() const {
  if (keyframes_.size() < 2) return std::nullopt;
  std::map<std::int64_t, int> observations;
  for (const Keyframe& k : keyframes_)
    for (const PointObservation& s : k.seen) ++observations[s.landmark];

  MapSmoothing result;
  const std::vector<Eigen::Isometry3d> start = deformed_path();
  // Ceres eliminates parameters in the order of their addresses: only arrays give the same bytes in every
  // run.
  std::vector<Vector6> xi(keyframes_.size(), Vector6{});
  std::vector<Eigen::Vector3d> points;  // by order of first observation; never moves
  points.reserve(observations.size());
  std::map<std::int64_t, double*> point_of;
  ceres::CauchyLoss robust(settings_.huber_width);
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  ceres::Solver::Options options;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    const Keyframe& k = keyframes_[i];
    problem.AddParameterBlock(xi[i].data(), 6);
    options.linear_solver_ordering->AddElementToGroup(xi[i].data(), 1);
    if (i > 0 && k.motion) {
      const Matrix6d root = settings_.planar ? free_root_information<3>(k.motion->covariance)
                                             : free_root_information<6>(k.motion->covariance);
      problem.AddResidualBlock(new MotionError(start[i - 1], start[i], k.motion->T_from_to, root), nullptr,
                               xi[i - 1].data(), xi[i].data());
    }
    for (const PointObservation& s : k.seen) {
      if (observations[s.landmark] < 2) continue;
      auto [landmark, first] = point_of.try_emplace(s.landmark, nullptr);
      if (first) {
        landmark->second = points.emplace_back(start[i] * s.measurement.value).data();
        problem.AddParameterBlock(landmark->second, 3);
        options.linear_solver_ordering->AddElementToGroup(landmark->second, 0);
      }
      problem.AddResidualBlock(new ObservationError(start[i], s.measurement), &robust, xi[i].data(),
                               landmark->second);
    }
  }
  for (std::size_t i = 1; settings_.planar && i < xi.size(); ++i)
    problem.SetManifold(xi[i].data(), new ceres::SubsetManifold(6, {2, 3, 4}));  // x, y, heading free
  problem.SetParameterBlockConstant(xi.front().data());

  options.num_threads = 1;  // the same result everywhere
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.max_num_iterations = maximum_iterations;
  options.function_tolerance = 1e-4;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  for (const auto& [id, point] : point_of) result.landmarks[id] = Eigen::Map<const Eigen::Vector3d>(point);
  result.cost_before = summary.initial_cost;
  result.cost_after = summary.final_cost;
  result.residuals = static_cast<std::size_t>(problem.NumResiduals());
  for (std::size_t i = 0; i < keyframes_.size(); ++i)
    result.path.push_back(
        {keyframes_[i].utime, restrict_pose(start[i] * se3_exp(twist(xi[i].data())), settings_.planar)});
  result.T_world_correction = result.path.back().T_world_robot * keyframes_.back().T_world_robot.inverse();
  return result;
}

}  // namespace lcmslam

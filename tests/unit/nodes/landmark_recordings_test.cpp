// The recordings of landmarks through the processes that take them: MRCLAM against the true path and map,
// Victoria Park against a batch solution. Numbers go to the test's properties.

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <functional>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <lcmslam/landmarks_t.hpp>
#include <map>

#include "datasets/landmark_recording.hpp"
#include "evaluation/trajectory_error.hpp"
#include "fastslam/fastslam_node.hpp"
#include "messages/feature_messages.hpp"
#include "messages/geometry_messages.hpp"
#include "messages/motion_messages.hpp"
#include "messages/origin.hpp"
#include "odometry/odometry_node.hpp"
#include "unit/nodes/test_bus.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

fs::path data_folder() {
  const char* root = std::getenv("LCMSLAM_DATA");
  return root != nullptr ? fs::path(root) : fs::path(LCMSLAM_SOURCE_DIR) / "../shared/data";
}

struct Event {
  Utime utime;
  std::function<void(testing::TestBus&)> deliver;
};

template <class M>
M sent(M message) {
  set_origin(message, Origin{0, 1});
  return message;
}

struct Result {
  Trajectory online;                                  // what the filter said at each time
  Trajectory smoothed;                                // the path at the end
  std::map<std::int64_t, Eigen::Vector3d> landmarks;  // the map at the end
};

Trajectory path_of(const std::vector<pose_estimate_t>& messages) {
  Trajectory path;
  for (const auto& m : messages) path.push_back({m.utime, from_message(m.T_map_robot, "pose")});
  return path;
}

Result run(const LandmarkRecording& recording, const std::string& config_file, int seed) {
  ConfigNode config = ConfigNode::load(fs::path(LCMSLAM_SOURCE_DIR) / "config" / config_file);
  config.set("fastslam.seed", std::to_string(seed));
  testing::TestBus bus;
  if (!recording.twists.empty()) bus.add<OdometryNode>(config.section("odometry"));
  bus.add<FastSlamNode>(config.section("fastslam"));
  std::vector<Event> events;
  for (const Twist& twist : recording.twists)
    events.push_back({twist.utime, [&](auto& b) { b.deliver("TWIST", sent(to_message(twist))); }});
  for (const MotionSample& sample : recording.odometry)
    events.push_back(
        {sample.utime, [&](auto& b) { b.deliver("ODOMETRY", sent(to_message(sample, "external"))); }});
  for (const FeatureFrame& frame : recording.frames)
    events.push_back({frame.utime, [&](auto& b) { b.deliver("FEATURES", sent(to_message(frame))); }});
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.utime < b.utime; });
  for (const Event& event : events) event.deliver(bus);
  bus.finish();
  EXPECT_EQ(bus.decode_errors(), 0);
  Result result;
  result.online = path_of(bus.on<pose_estimate_t>("FASTSLAM_POSE"));
  result.smoothed = path_of(bus.on<pose_estimate_t>("FASTSLAM_SMOOTHED"));
  for (const auto& tile : bus.on<landmarks_t>("FASTSLAM_LANDMARKS"))
    for (const auto& l : tile.landmarks) result.landmarks[l.id] = {l.mean[0], l.mean[1], l.mean[2]};
  return result;
}

class MrclamRobot : public ::testing::TestWithParam<int> {};

TEST_P(MrclamRobot, OnlineEstimateAndMapAreNearTheTruth) {
  if (!fs::exists(data_folder() / "mrclam_dataset6"))
    GTEST_SKIP() << data_folder() << " is not there (LCMSLAM_DATA)";
  const auto recording = open_landmark_dataset(data_folder() / "mrclam_dataset6", GetParam());
  ASSERT_TRUE(recording);
  const Result result = run(*recording, "mrclam.yaml", 11);
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  settings.alignment = Alignment::se2;
  const TrajectoryReport online = evaluate(recording->truth, result.online, settings);
  const TrajectoryReport smoothed = evaluate(recording->truth, result.smoothed, settings);
  double squares = 0;
  for (const auto& [id, truth] : recording->landmark_truth) {
    ASSERT_EQ(result.landmarks.count(id), 1U) << "landmark " << id;
    const Eigen::Vector3d mean = smoothed.alignment.T_truth_estimate * result.landmarks.at(id);
    squares += (mean.head<2>() - truth).squaredNorm();
  }
  const double map_error = std::sqrt(squares / static_cast<double>(recording->landmark_truth.size()));
  RecordProperty("online_rmse", std::to_string(online.absolute.translation.rmse));
  RecordProperty("smoothed_rmse", std::to_string(smoothed.absolute.translation.rmse));
  RecordProperty("landmarks", std::to_string(map_error));
  EXPECT_LT(online.absolute.translation.rmse, 0.28);
  EXPECT_LT(smoothed.absolute.translation.rmse, 0.13);
  EXPECT_LT(map_error, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Robots, MrclamRobot, ::testing::Values(1, 3));

// The batch solution: all factors with the file's own covariances. Each pose starts where dead reckoning
// leads from the solution so far, which is found anew every 100 poses (from dead reckoning alone the
// heading is wrong by half a turn at the end, and the solver finds another valley).
struct OdometryFactor {
  Eigen::Vector3d step, sigma;
  template <class T>
  bool operator()(const T* a, const T* b, T* r) const {
    const T c = cos(a[2]), s = sin(a[2]), dx = b[0] - a[0], dy = b[1] - a[1];
    const T turn = b[2] - a[2] - step.z();
    r[0] = (c * dx + s * dy - step.x()) / sigma.x();
    r[1] = (-s * dx + c * dy - step.y()) / sigma.y();
    r[2] = (turn - 2 * M_PI * ceres::floor((turn + M_PI) / (2 * M_PI))) / sigma.z();
    return true;
  }
};

struct TreeFactor {
  Eigen::Vector2d offset;
  double sigma;
  template <class T>
  bool operator()(const T* pose, const T* tree, T* r) const {
    const T c = cos(pose[2]), s = sin(pose[2]), dx = tree[0] - pose[0], dy = tree[1] - pose[1];
    r[0] = (c * dx + s * dy - offset.x()) / sigma;
    r[1] = (-s * dx + c * dy - offset.y()) / sigma;
    return true;
  }
};

Trajectory solve_batch(const LandmarkRecording& recording, double& cost, std::size_t& residuals) {
  const std::size_t n = recording.odometry.size();
  std::vector<std::array<double, 3>> poses(n, {0, 0, 0});
  std::map<int, std::array<double, 2>> trees;
  const auto pose = [&](std::size_t i) { return planar_pose(poses[i][0], poses[i][1], poses[i][2]); };
  ceres::Problem problem;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  residuals = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) {
      const MotionSample &a = recording.odometry[i - 1], &b = recording.odometry[i];
      const Eigen::Isometry3d step = a.T_odom_robot.inverse() * b.T_odom_robot;
      const Eigen::Isometry3d T = pose(i - 1) * step;
      poses[i] = {T.translation().x(), T.translation().y(), yaw(T)};
      auto* factor = new OdometryFactor{{step.translation().x(), step.translation().y(), yaw(step)},
                                        {0.01, 0.002, 0.002}};
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<OdometryFactor, 3, 3, 3>(factor), nullptr,
                               poses[i - 1].data(), poses[i].data());
      residuals += 3;
    }
    for (const Feature& f : recording.frames[i].features) {
      const Eigen::Vector3d p = f.point.cast<double>(), m = pose(i) * p;
      auto& tree = trees.try_emplace(f.landmark_id, std::array<double, 2>{m.x(), m.y()}).first->second;
      auto* factor = new TreeFactor{p.head<2>(), static_cast<double>(f.depth_sigma)};
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<TreeFactor, 2, 3, 2>(factor), nullptr,
                               poses[i].data(), tree.data());
      residuals += 2;
    }
    if (i == 1) problem.SetParameterBlockConstant(poses[0].data());
    if (i % 100 != 99 && i + 1 != n) continue;
    options.max_num_iterations = i + 1 == n ? 100 : 8;
    ceres::Solve(options, &problem, &summary);
  }
  EXPECT_EQ(summary.termination_type, ceres::CONVERGENCE) << summary.BriefReport();
  cost = summary.final_cost;
  Trajectory path;
  for (std::size_t i = 0; i < n; ++i) path.push_back({recording.odometry[i].utime, pose(i)});
  return path;
}

TEST(VictoriaPark, OnlineEstimateIsNearTheBatchSolution) {
  if (!fs::exists(data_folder() / "victoria_park"))
    GTEST_SKIP() << data_folder() << " is not there (LCMSLAM_DATA)";
  const auto recording = open_landmark_dataset(data_folder() / "victoria_park");
  ASSERT_TRUE(recording);
  double cost = 0;
  std::size_t residuals = 0;
  const Trajectory batch = solve_batch(*recording, cost, residuals);
  RecordProperty("batch_cost_per_residual", std::to_string(cost / static_cast<double>(residuals)));
  EXPECT_LT(cost, 0.5 * static_cast<double>(residuals));  // as consistent as its covariances say
  const Result result = run(*recording, "victoria_park.yaml", 11);
  EvaluationSettings settings;
  settings.alignment = Alignment::se2;
  const TrajectoryReport report = evaluate(batch, result.online, settings);
  RecordProperty("rmse", std::to_string(report.absolute.translation.rmse));
  RecordProperty("maximum", std::to_string(report.absolute.translation.maximum));
  EXPECT_EQ(report.matched_poses, batch.size());
  EXPECT_LT(report.absolute.translation.rmse, 5);
  EXPECT_LT(report.absolute.translation.maximum, 15);
}

}  // namespace
}  // namespace lcmslam

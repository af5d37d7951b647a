// The recordings of landmarks through the processes that take them: MRCLAM against the true path and map,
// Victoria Park against a batch solution. Numbers go to the test's properties.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>

#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/support/test_bus.hpp"
#include "tools/study/batch_solution.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

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
  ConfigNode config = ConfigNode::load(source_folder() / "config" / config_file);
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
  LCMSLAM_SKIP_WITHOUT("mrclam_dataset6");
  const auto recording = open_landmark_dataset(recording_path("mrclam_dataset6"), GetParam());
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

// Against the batch solution of tools/study, a few filter seeds (all ten: lcmslam study --only landmarks).
TEST(VictoriaPark, OnlineEstimateIsNearTheBatchSolution) {
  LCMSLAM_SKIP_WITHOUT("victoria_park");
  const auto recording = open_landmark_dataset(recording_path("victoria_park"));
  ASSERT_TRUE(recording);
  const BatchSolution batch = solve_batch(*recording);
  std::cout << "batch solution: cost " << batch.cost << " of " << batch.residuals
            << " residuals, RMS odometry " << batch.odometry_rms << ", landmarks " << batch.landmark_rms
            << " sigma\n";
  ASSERT_TRUE(batch.converged);
  EXPECT_LT(batch.cost, 0.5 * static_cast<double>(batch.residuals));  // as consistent as its covariances say
  EXPECT_LT(batch.odometry_rms, 1);
  EXPECT_LT(batch.landmark_rms, 1);
  std::vector<double> errors;
  for (const int seed : {11, 12, 13}) {
    const Result result = run(*recording, "victoria_park.yaml", seed);
    EvaluationSettings settings;
    settings.alignment = Alignment::se2;
    const TrajectoryReport report = evaluate(batch.path, result.online, settings);
    std::cout << "seed " << seed << ": RMSE " << report.absolute.translation.rmse << ", maximum "
              << report.absolute.translation.maximum << " m\n";
    EXPECT_EQ(report.matched_poses, batch.path.size());
    EXPECT_LT(report.absolute.translation.rmse, 5);
    EXPECT_LT(report.absolute.translation.maximum, 12) << "seed " << seed;
    errors.push_back(report.absolute.translation.rmse);
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[1], 2.5);
}

}  // namespace
}  // namespace lcmslam

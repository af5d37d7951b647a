#include "tools/demo/run_recorder.hpp"
#include "tools/demo/run_summary.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "tests/unit/tools/mounted_camera.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

class Recorder : public ::testing::Test {
 protected:
  template <class M>
  void deliver(const std::string& channel, const M& message) {
    const auto bytes = encode_message(message);
    ASSERT_TRUE(inputs_.deliver(channel, bytes.data(), bytes.size()));
  }

  /// The robot's true path: a curve.
  static Eigen::Isometry3d path(Utime utime) {
    const double t = 1e-6 * static_cast<double>(utime);
    return planar_pose(0.5 * t, std::sin(t), std::atan2(std::cos(t), 0.5));
  }

  void truth(Utime utime, const std::string& frame, const Eigen::Isometry3d& T) {
    ground_truth_t m;
    m.utime = utime;
    m.seq = utime;
    m.sender = 1;
    m.frame = "world";
    m.child_frame = frame;
    m.T_frame_child = to_message(T);
    deliver("GROUND_TRUTH", m);
  }

  void pose(const std::string& channel, Utime utime, const Eigen::Isometry3d& T, std::int64_t sender = 5,
            std::int8_t status = pose_estimate_t::TRACKING) {
    pose_estimate_t m = make_pose_estimate(utime, T, Matrix6d::Identity());
    m.seq = 0;
    m.sender = sender;
    m.status = status;
    deliver(channel, m);
  }

  void camera_status(std::int8_t state, const std::string& detail) {
    status_t s{};
    s.process = "camera";
    s.state = state;
    s.detail = detail;
    deliver("STATUS", s);
  }

  Inputs inputs_;
  RunRecorder recorder_{inputs_};
};

TEST_F(Recorder, EvaluatesEachPathAgainstTheTruth) {
  const Eigen::Isometry3d T_map_world = planar_pose(3, -2, 1);  // a map begins anywhere
  for (Utime t = 0; t <= 10'000'000; t += 20'000) truth(t, "robot", path(t));
  for (Utime t = 50'000; t < 10'000'000; t += 100'000) {
    pose("FASTSLAM_POSE", t, T_map_world * path(t));
    const double error = (t / 100'000) % 2 == 0 ? 0.01 : -0.01;
    pose("ICP_POSE", t, T_map_world * path(t) * planar_pose(0, error, 0));
  }
  const auto exact = recorder_.evaluate_path(recorder_.fastslam());
  const auto noisy = recorder_.evaluate_path(recorder_.icp());
  ASSERT_TRUE(exact && noisy);
  EXPECT_EQ(exact->matched_poses, recorder_.fastslam().trajectory.size());
  EXPECT_LT(exact->absolute.translation.rmse, 2e-4);  // interpolation of the truth
  EXPECT_NEAR(noisy->absolute.translation.rmse, 0.01, 5e-4);
  EXPECT_FALSE(recorder_.evaluate_path(recorder_.odometry()));  // there was none
}

// A GPS of 4 Hz, say: its gaps are too long to interpolate, and whoever reads the summary learns that.
TEST_F(Recorder, WhyAPathWasNotComparedIsSaid) {
  for (Utime t = 0; t <= 10'000'000; t += 250'000) truth(t, "robot", path(t));
  for (Utime t = 60'000; t < 10'000'000; t += 100'000) pose("ICP_POSE", t, path(t));
  std::string why;
  EXPECT_FALSE(recorder_.evaluate_path(recorder_.icp(), &why));
  EXPECT_THAT(why, ::testing::HasSubstr("that are at most 0.2 s apart"));
  EXPECT_THAT(format_summary(recorder_, RunFacts()),
              ::testing::HasSubstr("icp was not compared with the truth: " + why + "\n"));
}

// The file may be another one, or gone, when a run of hours ends.
TEST_F(Recorder, SummaryHasTheConfigurationThatTheRunBeganWith) {
  const testing::ScratchFolder scratch;
  RunFacts facts;
  facts.config = scratch.path() / "gone.yaml";
  facts.configuration = R"({"icp": {"voxel_size": 0.04}})";
  write_run_files(scratch.path(), recorder_, facts);
  const auto summary = nlohmann::json::parse(scratch.read("summary.json"));
  EXPECT_EQ(summary.at("configuration").at("icp").at("voxel_size"), 0.04);
}

TEST_F(Recorder, TruthOfTheCameraIsToldOfTheRobot) {
  const RgbdCalibration c = testing::mounted_camera();
  for (Utime t = 0; t < 1'000'000; t += 100'000) truth(t, "camera", path(t) * c.T_robot_camera);
  EXPECT_TRUE(recorder_.truth().empty()) << "not known yet";
  deliver("CAMERA_CALIBRATION", [&] {
    camera_calibration_t m = to_message(c);
    m.seq = m.sender = 0;
    return m;
  }());
  const Trajectory truth = recorder_.truth();
  ASSERT_EQ(truth.size(), 10U);
  for (const StampedPose& p : truth) EXPECT_TRUE(p.T_world_body.isApprox(path(p.utime), 1e-9)) << p.utime;
}

// Nor is another body's path: errors against it are of nobody.
TEST_F(Recorder, TruthThatNobodyPlacesOnTheRobotIsNotCompared) {
  for (const char* body : {"camera", "helmet"}) {
    SCOPED_TRACE(body);
    for (Utime t = 0; t < 1'000'000; t += 100'000) truth(t, body, path(t));
    for (Utime t = 50'000; t < 900'000; t += 100'000) pose("ICP_POSE", t, path(t));
    EXPECT_TRUE(recorder_.truth().empty());
    EXPECT_FALSE(recorder_.evaluate_path(recorder_.icp()));
    EXPECT_THAT(recorder_.truth_problem(), ::testing::HasSubstr(body));
    EXPECT_THAT(format_summary(recorder_, RunFacts()),
                ::testing::HasSubstr(recorder_.truth_problem() + "\n"));
  }
}

TEST_F(Recorder, RestartOfASenderClearsThePath) {
  for (Utime t = 0; t < 500'000; t += 100'000) pose("ICP_POSE", t, path(t), 5);
  for (Utime t = 500'000; t < 700'000; t += 100'000) pose("ICP_POSE", t, path(t), 6);
  EXPECT_EQ(recorder_.icp().trajectory.size(), 2U);
  EXPECT_EQ(recorder_.icp().restarts, 1);
  EXPECT_EQ(recorder_.fastslam().restarts, 0);
}

// Errors of the newest map alone look like those of the whole drive.
TEST_F(Recorder, SummarySaysWhoBeganAgain) {
  RunFacts facts;
  for (Utime t = 0; t < 500'000; t += 100'000) pose("ICP_POSE", t, path(t), 5);
  EXPECT_THAT(format_summary(recorder_, facts), ::testing::Not(::testing::HasSubstr("began again")));
  for (Utime t = 500'000; t < 700'000; t += 100'000) pose("ICP_POSE", t, path(t), 6);
  EXPECT_THAT(format_summary(recorder_, facts),
              ::testing::HasSubstr("icp began again 1 time: poses and errors are of its newest map\n"));
}

TEST_F(Recorder, JumpBackInTimeClearsThePathButALatePoseDoesNot) {
  for (const Utime t : {10'000'000, 10'100'000, 10'050'000}) pose("ICP_POSE", t, path(t));
  EXPECT_EQ(recorder_.icp().restarts, 0);
  EXPECT_EQ(recorder_.icp().trajectory.size(), 3U);
  pose("ICP_POSE", 1'000'000, path(0));
  EXPECT_EQ(recorder_.icp().restarts, 1);
  EXPECT_EQ(recorder_.icp().trajectory.size(), 1U);
}

TEST_F(Recorder, CountsWhatTheMapperSaysOfItself) {
  pose("FASTSLAM_POSE", 1, path(1), 5, pose_estimate_t::LOST);
  pose("FASTSLAM_POSE", 2, path(2), 5, pose_estimate_t::DEGRADED);
  pose("FASTSLAM_POSE", 3, path(3), 5, pose_estimate_t::TRACKING);
  EXPECT_EQ(recorder_.fastslam().lost, 1);
  EXPECT_EQ(recorder_.fastslam().degraded, 1);
}

TEST_F(Recorder, ProgressChangesWithEveryPose) {
  Utime last = recorder_.progress();
  for (Utime t = 100; t < 500; t += 100) {
    pose(t % 200 == 0 ? "ICP_POSE" : "FASTSLAM_POSE", t, path(t));
    EXPECT_NE(recorder_.progress(), last);
    last = recorder_.progress();
  }
}

TEST_F(Recorder, KnowsWhenTheSourceIsAtItsEndOrFailed) {
  std::string reason;
  EXPECT_FALSE(recorder_.source_finished());
  EXPECT_FALSE(recorder_.source_failed(reason));
  camera_status(status_t::RUNNING, "");
  EXPECT_FALSE(recorder_.source_finished());
  camera_status(status_t::FINISHED, "");
  EXPECT_TRUE(recorder_.source_finished());
  camera_status(status_t::FAILED, "no such folder");
  EXPECT_TRUE(recorder_.source_failed(reason));
  EXPECT_EQ(reason, "no such folder");
}

// Some paths thinned more than others, or the beginning more than the end, would leave gaps.
TEST(ThinnedPath, IsThinnedAlikeAllAlong) {
  ThinnedPath path;
  for (Utime i = 0; i < 3000; ++i) path.add({i, Eigen::Isometry3d::Identity()}, 100);
  EXPECT_EQ(path.every, 32);
  ASSERT_GT(path.trajectory.size(), 40U);
  for (std::size_t i = 0; i < path.trajectory.size(); ++i)
    EXPECT_EQ(path.trajectory[i].utime, 32 * static_cast<Utime>(i));
}

// A graph that runs for days must not fill the memory with its path.
TEST_F(Recorder, OfALongPathEverySecondPoseIsKept) {
  for (Utime i = 0; i < 200'000; ++i) pose("ICP_POSE", 33'000 * i, Eigen::Isometry3d::Identity());
  EXPECT_EQ(recorder_.icp().every, 2);
  ASSERT_EQ(recorder_.icp().trajectory.size(), 100'000U);
  EXPECT_EQ(recorder_.icp().trajectory[7].utime, 14 * 33'000);
  pose("ICP_POSE", 33'000 * 200'000L, Eigen::Isometry3d::Identity());
  pose("ICP_POSE", 33'000 * 200'001L, Eigen::Isometry3d::Identity());
  EXPECT_EQ(recorder_.icp().trajectory.size(), 100'001U);
  EXPECT_EQ(recorder_.icp().trajectory.back().utime, 33'000 * 200'000L);
}

}  // namespace
}  // namespace lcmslam

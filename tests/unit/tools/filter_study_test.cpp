#include "tools/study/filter_study.hpp"
#include "tests/support/source_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/resampling_study.hpp"

namespace lcmslam {
namespace {

const std::string kitchen = source_folder() / "logs/kitchen.lcmlog";
const std::string replay = source_folder() / "config/replay.yaml";

// A robot that stands, drives off and comes back; the path says that it came back 0.1 m aside.
TEST(Reunion, ApartIsWhatThePathIsOff) {
  Random random(3);
  std::vector<Feature> things;
  for (int i = 0; i < 40; ++i) {
    Feature f;
    f.kind = MeasurementKind::point;
    f.point =
        Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 3)).cast<float>();
    f.laplacian = 1;
    for (auto& byte : f.descriptor) byte = static_cast<std::uint8_t>(random.below(256));
    things.push_back(f);
  }
  std::vector<FeatureFrame> frames;
  Trajectory truth, path;
  for (int i = 0; i < 40; ++i) {
    FeatureFrame frame;
    frame.utime = 1'000'000 + i * 100'000;
    const bool away = i >= 10 && i < 30;
    if (!away) frame.features = things;
    frames.push_back(frame);
    const Eigen::Isometry3d T = planar_pose(away ? 5 : 0, 0, 0);
    truth.push_back({frame.utime, T});
    path.push_back({frame.utime, i < 30 ? T : planar_pose(0, 0.1, 0) * T});
  }
  const std::vector<double> distances = reunion_distances(frames, truth, path);
  ASSERT_GE(distances.size(), 40U);
  for (const double d : distances) EXPECT_NEAR(d, 0.1, 1e-6);
  for (const double d : reunion_distances(frames, truth, truth)) EXPECT_NEAR(d, 0, 1e-9);
  for (StampedPose& pose : truth)
    if (pose.utime > 3'000'000) pose.T_world_body = planar_pose(9, 0, 0);  // it never comes back
  EXPECT_TRUE(reunion_distances(frames, truth, path).empty());
}

TEST(FilterStudy, ScoresALogAndTheNoiseThatIsTakenAway) {
  const SurfaceDistance plane = [](const Eigen::Vector3d& p) { return std::abs(p.z()); };
  const ConfigNode config = load_config(
      replay, {"odometry.noise.mode=random_walk", "odometry.noise.sigma=0.02", "fastslam.particles=50"});
  const std::vector<FilterScore> scores = study_filter({kitchen}, config, {1, 2}, plane);
  ASSERT_EQ(scores.size(), 2U);
  for (const FilterScore& s : scores) {
    EXPECT_EQ(s.log, "kitchen");
    EXPECT_GT(s.odometry, s.clean);
    EXPECT_LT(s.fastslam, 0.5 * s.odometry) << "seed " << s.seed;
    EXPECT_NEAR(s.corrected, (s.odometry - s.fastslam) / (s.odometry - s.clean), 1e-12);
    EXPECT_GT(s.corrected, 0.5);
    EXPECT_GT(s.landmarks, 0);
    EXPECT_LE(s.landmarks, s.landmarks_p90);
  }
  EXPECT_NE(scores[0].odometry, scores[1].odometry);  // each seed has noise of its own
  const std::string table = filter_table(scores);
  EXPECT_NE(table.find("median"), std::string::npos);
  EXPECT_EQ(filter_json(scores).at("runs").size(), 2U);
  const auto again = study_filter({kitchen}, config, {1}, plane);
  EXPECT_EQ(again[0].fastslam, scores[0].fastslam);
}

/// The drive, and then all of it again: time leaps back, and the filter begins a new map.
std::vector<BatchMessage> begun_again(std::vector<BatchMessage> messages) {
  const std::vector<BatchMessage> again = messages;
  messages.insert(messages.end(), again.begin(), again.end());
  return messages;
}

// An error of the newest map alone is smaller for being of less.
TEST(FilterStudy, ARunThatBeganANewMapIsInNoMedian) {
  const ConfigNode config = load_config(replay, {"fastslam.particles=20"});
  PreparedLog log = prepare_log(kitchen, config, 1);
  EXPECT_EQ(run_filter(log, config, 1).restarts, 0);
  log.messages = begun_again(log.messages);
  const FilterRun run = run_filter(log, config, 1);
  EXPECT_EQ(run.restarts, 1);
  EXPECT_EQ(score_filter(log, run, std::nan(""), {}).restarts, 1);
  FilterScore whole, broken;
  whole.fastslam = 0.25;
  broken.fastslam = 0.0625;
  broken.restarts = 2;
  const std::string table = filter_table({whole, broken, broken});
  const std::string median = table.substr(table.find("median"));
  EXPECT_NE(median.find("0.2500"), std::string::npos) << table;
  EXPECT_EQ(median.find("0.0625"), std::string::npos) << table;
  EXPECT_NE(table.find("2 of 3 runs began a new map"), std::string::npos) << table;
  EXPECT_EQ(filter_json({broken}).at("runs")[0].at("restarts"), 2);
}

TEST(MappingRun, AMapperThatBeganANewMapHasNeitherPathNorMap) {
  const PreparedLog log = prepare_log(kitchen, load_config(replay, {}), 1);
  Drive drive;
  drive.messages = log.messages;
  drive.truth = log.truth;
  MapperChoice choice;
  choice.icp = false;
  choice.set = {"fastslam.particles=20"};
  const MappingRun whole = map_drive(drive, choice);
  EXPECT_EQ(whole.fastslam_restarts, 0);
  EXPECT_TRUE(std::isfinite(path_error(drive.truth, whole.fastslam)));
  EXPECT_FALSE(whole.landmarks.empty());
  drive.messages = begun_again(log.messages);
  const MappingRun broken = map_drive(drive, choice);
  EXPECT_EQ(broken.fastslam_restarts, 1);
  EXPECT_TRUE(std::isnan(path_error(drive.truth, broken.fastslam)));
  EXPECT_TRUE(broken.landmarks.empty());
}

TEST(FilterStudy, TheWorstRunsLossesAreNotTheSum) {
  FilterScore few, many;
  few.lost = 3;
  many.lost = 40;
  const std::string table = filter_table({few, many});
  const std::string worst = table.substr(table.find("worst"));
  EXPECT_NE(worst.find(" 40 "), std::string::npos) << table;
  EXPECT_EQ(worst.find("43"), std::string::npos) << table;
}

TEST(ResamplingStudy, ARunThatBeganANewMapIsInNoMedian) {
  ResamplingScore whole, broken;
  whole.ate = 0.25;
  broken.ate = 0.0625;
  broken.restarts = 1;
  const std::string table = resampling_table({whole, broken, broken});
  EXPECT_NE(table.find("0.2500"), std::string::npos) << table;
  EXPECT_EQ(table.find("0.0625"), std::string::npos) << table;
  EXPECT_NE(table.find("2 of 3 runs began a new map"), std::string::npos) << table;
  EXPECT_EQ(resampling_table({broken}).find("0.0625"), std::string::npos);
}

// As FastSLAM hears them in the whole graph: of a rolling shutter it straightens the rows.
TEST(FilterStudy, TheFilterHearsTheCalibrationBeforeFeatures) {
  const PreparedLog log = prepare_log(kitchen, load_config(replay, {}), 1);
  const auto first = [&](const std::string& channel) {
    return std::find_if(log.messages.begin(), log.messages.end(),
                        [&](const BatchMessage& m) { return m.channel == channel; });
  };
  ASSERT_NE(first("FEATURES"), log.messages.end());
  EXPECT_LT(first("CAMERA_CALIBRATION"), first("FEATURES"));
}

TEST(FilterStudy, NamesALogWithoutImages) {
  EXPECT_THROW(prepare_log(replay, load_config(replay, {}), 1), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam

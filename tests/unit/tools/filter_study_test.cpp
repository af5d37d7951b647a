#include "tools/study/filter_study.hpp"
#include "tests/support/source_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/runtime/options.hpp>

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

TEST(FilterStudy, NamesALogWithoutImages) {
  EXPECT_THROW(prepare_log(replay, load_config(replay, {}), 1), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam

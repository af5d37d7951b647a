// Published trajectories, against a second computation from the definition and against what published
// tools give.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include <lcmslam/evaluation/trajectory_error.hpp>
#include "tests/support/recordings.hpp"
#include "tests/unit/evaluation/ate_by_definition.hpp"
#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

class RecordedTrajectories : public ::testing::Test {
 protected:
  void SetUp() override { LCMSLAM_SKIP_WITHOUT("trajectories"); }

  /// The error, after it has been compared with the definition's.
  double check(const std::string& truth_name, const std::string& estimate_name,
               Alignment alignment = Alignment::se3) {
    EvaluationSettings settings;
    settings.alignment = alignment;
    const TrajectoryReport report =
        evaluate(read_tum(folder_ / truth_name), read_tum(folder_ / estimate_name), settings);
    const auto wanted = testing::ate_by_definition(folder_ / truth_name, folder_ / estimate_name,
                                                   alignment == Alignment::sim3);
    EXPECT_GT(wanted.pairs, 20u);
    EXPECT_EQ(report.matched_poses, wanted.pairs);
    // Whole microseconds break a few ties between pairs differently than seconds in a double do.
    EXPECT_NEAR(report.absolute.translation.rmse, wanted.rmse, 1e-5);
    EXPECT_NEAR(report.alignment.scale, wanted.scale, 1e-5);
    std::cout << estimate_name << ": ATE " << report.absolute.translation.rmse << " m (definition "
              << wanted.rmse << "), scale " << report.alignment.scale << ", " << wanted.pairs
              << " matches, RPE " << report.per_second.translation.rmse << " m and "
              << report.per_second.rotation.rmse << " rad per second\n";
    return report.absolute.translation.rmse;
  }

  const std::filesystem::path folder_ = recording_path("trajectories");
};

TEST_F(RecordedTrajectories, FreiburgXyzRgbdSlamHasThePublishedError) {
  EXPECT_NEAR(check("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam.txt"), 0.013473, 1e-6);
}

// The same path in another world.
TEST_F(RecordedTrajectories, FreiburgXyzRgbdSlamWithDrift) {
  EXPECT_NEAR(check("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam_drift.txt"), 0.013473, 1e-6);
}

TEST_F(RecordedTrajectories, FreiburgDeskOrbSlam) {
  EXPECT_LT(check("fr2_desk_groundtruth.txt", "fr2_desk_ORB.txt"), 0.02);
}

// A monocular estimate has no scale: sim3 must beat se3 by far.
TEST_F(RecordedTrajectories, MonocularKeyframesNeedScale) {
  const double se3 = check("fr2_desk_groundtruth.txt", "fr2_desk_ORB_kf_mono.txt");
  const double sim3 = check("fr2_desk_groundtruth.txt", "fr2_desk_ORB_kf_mono.txt", Alignment::sim3);
  EXPECT_LT(sim3, 0.2 * se3);
}

}  // namespace
}  // namespace lcmslam

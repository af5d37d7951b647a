// When the map of 3-D landmarks is smoothed beside the filter, and what is taken over.

#include <lcmslam/fastslam/smoothing/background_map_smoothing.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace lcmslam {
namespace {

constexpr Utime smoothing_time = 2'000'000;  // us

// A robot drives a circle among points and sees them all; the filter's estimate drifts.
class SmoothedDrive {
 public:
  explicit SmoothedDrive(const FastSlamSettings& settings) : smoothing(settings) {
    Random random(2);
    for (int i = 0; i < 30; ++i)
      landmarks_.emplace_back(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(0, 2));
  }

  void step(bool loop_closed = false, TrackStatus status = TrackStatus::tracking) {
    const Eigen::Isometry3d T = planar_pose(std::sin(angle_), 1 - std::cos(angle_), angle_);
    StepResult result;
    result.T_world_best = T * planar_pose(0.002 * static_cast<double>(steps), 0, 0);
    result.status = status;
    result.loop_closed = loop_closed;
    std::vector<FeaturePoint> points(landmarks_.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].feature = static_cast<int>(i);
      points[i].measurement.value = T.inverse() * landmarks_[i];
      points[i].measurement.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      const auto outcome = i == 0 ? AssociationOutcome::rejected : AssociationOutcome::accepted;
      result.associations.push_back({static_cast<int>(i), static_cast<std::int64_t>(i), outcome});
    }
    Motion odometry;
    odometry.T_from_to = T_before_.inverse() * T;
    odometry.covariance = 1e-4 * Matrix6d::Identity();
    T_before_ = T;
    if (planar_from_now) points[3].measurement.kind = MeasurementKind::planar;
    utime = 1'000'000 + 100'000 * steps++;
    smoothing.add(utime, odometry, points, result);
    angle_ += 0.1;
  }

  BackgroundMapSmoothing smoothing;
  Utime utime = 0;  // of the newest step
  int steps = 0;
  bool planar_from_now = false;

 private:
  std::vector<Eigen::Vector3d> landmarks_;
  Eigen::Isometry3d T_before_ = Eigen::Isometry3d::Identity();
  double angle_ = 0;
};

TEST(BackgroundMapSmoothing, IsDueTwoSecondsAfterTheRequestOnce) {
  SmoothedDrive drive{FastSlamSettings()};
  EXPECT_FALSE(drive.smoothing.begin_on_request());  // no path yet
  for (int i = 0; i < 20; ++i) drive.step();
  EXPECT_TRUE(drive.smoothing.begin_on_request());
  EXPECT_TRUE(drive.smoothing.requested());
  EXPECT_FALSE(drive.smoothing.take_over_when_due(drive.utime + smoothing_time - 1));
  const Utime due = drive.utime + smoothing_time;
  for (int i = 0; i < 3; ++i) drive.step();  // meanwhile
  const auto taken = drive.smoothing.take_over_when_due(due);
  ASSERT_TRUE(taken && taken->smoothing);
  EXPECT_TRUE(taken->requested);
  EXPECT_EQ(taken->smoothing->path.size(), 20U) << "the path as it was then";
  EXPECT_EQ(taken->smoothing->landmarks.count(0), 0U) << "the best particle rejected it";
  EXPECT_EQ(taken->smoothing->landmarks.size(), 29U);
  EXPECT_FALSE(drive.smoothing.requested());
  EXPECT_FALSE(drive.smoothing.take_over_when_due(due + smoothing_time));
  EXPECT_EQ(drive.smoothing.smooth()->path.size(), 23U);
}

// The drift of the filter's estimate, which the observations contradict, is taken away.
TEST(BackgroundMapSmoothing, CorrectsTheNewestKeyframe) {
  SmoothedDrive drive{FastSlamSettings()};
  for (int i = 0; i < 20; ++i) drive.step();
  const auto smoothing = drive.smoothing.smooth();
  ASSERT_TRUE(smoothing);
  const Eigen::Vector3d drifted(0.002 * 19, 0, 0);
  const Eigen::Vector3d corrected = smoothing->path.back().T_world_robot.translation() -
                                    planar_pose(std::sin(1.9), 1 - std::cos(1.9), 1.9).translation();
  EXPECT_LT(corrected.norm(), 0.1 * drifted.norm());
}

TEST(BackgroundMapSmoothing, AClosedLoopBeginsItWhereTheSettingsWantThat) {
  for (const bool wanted : {false, true}) {
    FastSlamSettings settings;
    settings.bend_closed_loops = wanted;
    SmoothedDrive drive(settings);
    for (int i = 0; i < 10; ++i) drive.step();
    drive.step(true, TrackStatus::relocalised);
    EXPECT_FALSE(drive.smoothing.requested());
    const auto taken = drive.smoothing.take_over_when_due(drive.utime + smoothing_time);
    EXPECT_EQ(taken.has_value(), wanted);
    if (taken) {
      EXPECT_FALSE(taken->requested);
    }
  }
}

TEST(BackgroundMapSmoothing, EndsForGoodWhereThePlaneIsMeasuredButWhatRunsIsTakenOver) {
  SmoothedDrive drive{FastSlamSettings()};
  for (int i = 0; i < 10; ++i) drive.step();
  drive.smoothing.begin_on_request();
  EXPECT_TRUE(drive.smoothing.active());
  drive.planar_from_now = true;
  drive.step();
  EXPECT_FALSE(drive.smoothing.active());
  drive.planar_from_now = false;
  drive.step();
  EXPECT_FALSE(drive.smoothing.active());
  const auto taken = drive.smoothing.take_over_when_due(drive.utime + smoothing_time);
  ASSERT_TRUE(taken && taken->smoothing);
  EXPECT_EQ(taken->smoothing->path.size(), 10U);
  EXPECT_FALSE(drive.smoothing.begin_on_request());
  EXPECT_FALSE(drive.smoothing.smooth());
}

}  // namespace
}  // namespace lcmslam

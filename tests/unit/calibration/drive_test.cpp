// Mount and wheels from drives whose truth is known.

#include <lcmslam/calibration/drive_calibration.hpp>

#include <gmock/gmock.h>

#include <lcmslam/calibration/floor_sight.hpp>
#include "tests/support/camera_drive.hpp"
#include "tests/support/dark_frame.hpp"
#include "tests/support/floor_before_wall.hpp"

namespace lcmslam {
namespace {

constexpr double degree = M_PI / 180;
constexpr Utime start_time = 1'000'000;

/// 1.3 m high, inclined by 20 degrees, a little beside the middle.
Eigen::Isometry3d true_mount() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.12, -0.03, 1.3;
  T.rotate(Eigen::AngleAxisd(3 * degree, Eigen::Vector3d::UnitZ()));
  T.rotate(Eigen::AngleAxisd(20 * degree, Eigen::Vector3d::UnitY()));
  return T * optical_axes();
}

/// 2 cm and 1 degree beside it.
Eigen::Isometry3d rough_mount() {
  Vector6d step;
  step << 0.02, -0.02, 0.02, degree, -degree, degree;
  return true_mount() * se3_exp(step);
}

FloorSight true_floor() {
  FloorSight floor;
  floor.up = true_mount().linear().transpose() * Eigen::Vector3d::UnitZ();
  floor.height = true_mount().translation().z();
  floor.up_sigma = 0.001, floor.height_sigma = 0.002, floor.images = 100;
  return floor;
}

double planar_distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).head<2>().norm();
}

TEST(DriveCalibration, WithGoodWheelsTheMountIsFoundAndItsHeightIsNot) {
  const DrivenPath path(testing::figure_of_eight(2));
  const auto stretches =
      cut_drive(testing::seen_motion(path, true_mount(), start_time, 1, {1e-4, 1e-5}),
                wheel_steps(simulate_encoders(path, "differential", start_time, 1, WheelErrors::none())));
  const DriveCalibration found = calibrate_drive(stretches, std::nullopt, rough_mount());
  EXPECT_FALSE(found.height_observed);
  EXPECT_LT(planar_distance(found.T_robot_camera, true_mount()), 0.001);
  EXPECT_LT(angle_between(found.T_robot_camera, true_mount()), 0.05 * degree);
  EXPECT_NEAR(found.T_robot_camera.translation().z(), rough_mount().translation().z(), 0.001);
  EXPECT_NEAR(found.robot_sigmas()[2], 1, 0.01) << "nobody measured it";
  EXPECT_LT(found.robot_sigmas().head<2>().maxCoeff(), 0.005);
  for (const double factor : found.radius_factors) EXPECT_NEAR(factor, 1, 0.002);
  EXPECT_NEAR(found.layout_factor, 1, 0.002);
  EXPECT_EQ(found.slips, 0);
}

TEST(DriveCalibration, TheFloorTellsTheHeight) {
  const DrivenPath path(testing::figure_of_eight(2));
  const auto stretches = cut_drive(testing::seen_motion(path, true_mount(), start_time, 2),
                                   wheel_steps(simulate_encoders(path, "differential", start_time, 2)));
  const DriveCalibration found = calibrate_drive(stretches, true_floor(), rough_mount());
  EXPECT_TRUE(found.height_observed);
  EXPECT_NEAR(found.T_robot_camera.translation().z(), 1.3, 0.001);
  EXPECT_LT(angle_between(found.T_robot_camera, true_mount()), 0.4 * degree);
  // It knows how sure it is.
  const Vector6d xi = se3_log(true_mount().inverse() * found.T_robot_camera);
  EXPECT_LT(xi.dot(found.covariance.ldlt().solve(xi)), 25);
}

// Hundreds of stretches add their noise up, and none of them knows the height: the start's is 0, as a
// calibration without a mount has it.
TEST(DriveCalibration, ManyStretchesDoNotPullTheHeightToTheStarts) {
  FloorSight floor = true_floor();
  floor.height_sigma = 0.018;
  Eigen::Isometry3d start = true_mount();
  start.translation().z() = 0;
  const DrivenPath path(testing::figure_of_eight(16));
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto stretches =
        cut_drive(testing::seen_motion(path, true_mount(), start_time, seed, {0.002, 0.002}),
                  wheel_steps(simulate_encoders(path, "differential", start_time, seed)));
    ASSERT_GT(stretches.size(), 300U);
    floor.height = true_floor().height + floor.height_sigma * Random(seed).normal();
    const DriveCalibration found = calibrate_drive(stretches, floor, start);
    EXPECT_NEAR(found.T_robot_camera.translation().z(), floor.height, 1e-4) << "seed " << seed;
    EXPECT_GE(found.robot_sigmas()[2], 0.999 * floor.height_sigma) << "seed " << seed;
    EXPECT_LT(std::abs(found.T_robot_camera.translation().z() - true_mount().translation().z()),
              3 * found.robot_sigmas()[2])
        << "seed " << seed;
  }
}

// The pitch that is corrected must not turn what the floor leaves open of the height into x.
TEST(DriveCalibration, IsAsSureFromARoughStartAsFromTheTruth) {
  FloorSight floor = true_floor();
  floor.height_sigma = 0.02;
  const DrivenPath path(testing::figure_of_eight(4));
  const auto stretches = cut_drive(testing::seen_motion(path, true_mount(), start_time, 5),
                                   wheel_steps(simulate_encoders(path, "differential", start_time, 5)));
  const Eigen::Isometry3d pitched =
      true_mount() * Eigen::Isometry3d(Eigen::AngleAxisd(17 * degree, Eigen::Vector3d::UnitX()));
  const DriveCalibration near = calibrate_drive(stretches, floor, true_mount()),
                         far = calibrate_drive(stretches, floor, pitched);
  EXPECT_LT(angle_between(near.T_robot_camera, far.T_robot_camera), 0.02 * degree);
  const Vector6d ratio = far.robot_sigmas().cwiseQuotient(near.robot_sigmas());
  EXPECT_LT((ratio - Vector6d::Ones()).cwiseAbs().maxCoeff(), 0.02) << ratio.transpose();
}

TEST(DriveCalibration, WheelsAreAsLargeAsTheyCount) {
  // What wheels measure too much: the true radius is so much smaller, and so is the track for what turns
  // measure less.
  WheelErrors errors = WheelErrors::none();
  errors.translation_scale = 0.02, errors.rotation_scale = 0.03;
  const DrivenPath path(testing::figure_of_eight(3));
  const auto encoders = simulate_encoders(path, "differential", start_time, 3, errors);
  const auto true_way = [&] {
    double way = 0, turn = 0;
    for (double t = 0; t < path.duration(); t += 0.02) {
      const Vector6d step = se3_log(path.pose(t).inverse() * path.pose(t + 0.02));
      way += step.head<2>().norm(), turn += std::abs(step[5]);
    }
    return std::make_pair(way, turn);
  }();
  double way = 0, turn = 0;
  const auto steps = wheel_steps(encoders);
  for (const WheelStep& step : steps) {
    const Eigen::Vector3d motion = step.by_wheel.rowwise().sum();
    way += motion.head<2>().norm(), turn += std::abs(motion.z());
  }
  const double way_scale = way / true_way.first, turn_scale = turn / true_way.second;
  ASSERT_GT(std::abs(way_scale - 1), 0.01);
  const DriveCalibration found = calibrate_drive(
      cut_drive(testing::seen_motion(path, true_mount(), start_time, 3), steps), true_floor(), rough_mount());
  ASSERT_EQ(found.radius_factors.size(), 2u);
  for (const double factor : found.radius_factors) EXPECT_NEAR(factor * way_scale, 1, 0.004);
  EXPECT_NEAR(found.layout_factor * way_scale / turn_scale, 1, 0.006);
}

TEST(DriveCalibration, StretchesEndWhereTheCameraWasLost) {
  const DrivenPath path(testing::figure_of_eight(1));
  auto seen = testing::seen_motion(path, true_mount(), start_time, 4);
  const auto steps = wheel_steps(simulate_encoders(path, "differential", start_time, 4));
  const std::size_t all = cut_drive(seen, steps).size();
  seen.erase(seen.begin() + 100, seen.begin() + 140);
  const auto with_gap = cut_drive(seen, steps);
  EXPECT_LT(with_gap.size(), all);
  for (const Stretch& stretch : with_gap) EXPECT_LT(stretch.T_from_to.translation().norm(), 0.8);
}

// One that comes once more, later: from it to the next the robot did not drive again.
TEST(DriveCalibration, AWheelReadingThatComesLateIsLeftOut) {
  const auto way_of_all = [](const std::vector<WheelStep>& steps) {
    double way = 0;
    for (const WheelStep& step : steps) way += step.way;
    return way;
  };
  auto encoders = simulate_encoders(DrivenPath(testing::figure_of_eight(1)), "differential", start_time, 4);
  std::vector<MotionSample> odometry(100);
  for (int i = 0; i < 100; ++i) {
    odometry[static_cast<std::size_t>(i)].utime = i * 100'000;
    odometry[static_cast<std::size_t>(i)].T_odom_robot = planar_pose(0.1 * i, 0, 0);
  }
  const double by_encoders = way_of_all(wheel_steps(encoders)),
               by_odometry = way_of_all(wheel_steps(odometry));
  encoders.insert(encoders.begin() + 60, encoders[53]);
  odometry.insert(odometry.begin() + 60, odometry[53]);
  EXPECT_NEAR(way_of_all(wheel_steps(encoders)), by_encoders, 1e-9);
  EXPECT_NEAR(way_of_all(wheel_steps(odometry)), by_odometry, 1e-9);
}

TEST(DriveCalibration, AShortDriveIsRefused) {
  EXPECT_THROW(calibrate_drive({}, std::nullopt, true_mount()), std::invalid_argument);
}

TEST(DriveCalibration, OdometryOfAnotherDriverHasOneColumn) {
  std::vector<MotionSample> odometry(3);
  for (int i = 0; i < 3; ++i) {
    odometry[static_cast<std::size_t>(i)].utime = i * 100'000;
    odometry[static_cast<std::size_t>(i)].T_odom_robot = planar_pose(0.1 * i, 0, 0.02 * i);
  }
  const auto steps = wheel_steps(odometry);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].by_wheel.cols(), 1);
  EXPECT_NEAR(steps[0].by_wheel(2, 0), 0.02, 1e-9);
}

// In three of five images a sliver of both looks upwards, and the floor would be a metre lower there.
TEST(FloorWatch, WhereItMeetsAWallTheFloorIsFound) {
  constexpr std::uint64_t seed = 6;  // of the bench calibration_quality
  const testing::RgbdTruth truth = testing::drawn_head(seed);
  Random random(seed, 41);
  const Eigen::Isometry3d mount = testing::drawn_mount(random);
  const DepthCorrector correct(truth.calibration.depth, truth.calibration.depth_error);
  FloorWatch watch(truth.calibration, mount);
  for (int image = 0; image < 60; ++image) {
    cv::Mat depth = testing::floor_before_wall(truth, mount, random);
    correct(depth);
    watch.add(depth);
  }
  const auto sight = watch.sight();
  ASSERT_TRUE(sight);
  EXPECT_NEAR(sight->height, mount.translation().z(), 0.005);
  EXPECT_LT(sight->height_sigma, 0.005);
}

/// By images of something level below the camera, at these heights in turn.
FloorSight sight_of_levels(const std::vector<double>& heights, int images) {
  const RgbdCalibration c = testing::phase_head();
  const Eigen::Isometry3d mount = true_mount();
  FloorWatch watch(c, mount);
  for (int image = 0; image < images; ++image) {
    cv::Mat depth(c.depth.height, c.depth.width, CV_16UC1, cv::Scalar(0));
    for (int v = 0; v < depth.rows; ++v)
      for (int u = 0; u < depth.cols; ++u) {
        const Eigen::Vector3d down = mount.linear() * c.depth.ray({u, v});
        const double z =
            -heights[static_cast<std::size_t>(image) % heights.size()] / std::min(-1e-9, down.z());
        if (z < 4) depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(1000 * z));
      }
    watch.add(depth);
  }
  return watch.sight().value();
}

TEST(FloorWatch, SeveralHeightsAreNoSurerForBeingSeenOften) {
  const FloorSight floor = sight_of_levels({1.3, 1.3, 1.3, 0.6}, 100);
  EXPECT_NEAR(floor.height, 1.3, 0.003);
  EXPECT_LT(floor.height_sigma, 0.01);
  const FloorSight tables = sight_of_levels({0.6, 1.3, 0.6, 1.3, 0.6}, 100);
  EXPECT_GT(tables.height_sigma, 0.5) << "three of five images show a table";
}

}  // namespace
}  // namespace lcmslam

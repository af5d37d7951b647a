#include <lcmslam/odometry/visual_odometry.hpp>

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <iostream>
#include <map>
#include <tuple>

#include <lcmslam/evaluation/trajectory_error.hpp>
#include "tests/support/recordings.hpp"
#include "tests/unit/odometry/tum_recording.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

// Points on the walls of a room with a descriptor each, seen by a perfect camera.
class Room {
 public:
  explicit Room(int points) {
    Random random(17);
    for (int i = 0; i < points; ++i) {
      Eigen::Vector3d p(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-1.5, 1.5));
      p[i % 2] = (i % 4 < 2 ? -4 : 4);  // on one of four walls
      points_.push_back(p);
      Descriptor descriptor;
      for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(random.below(256));
      descriptors_.push_back(descriptor);
    }
  }

  FeatureFrame see(const Eigen::Isometry3d& T_world_robot, Utime utime,
                   const Eigen::Isometry3d& T_robot_camera) const {
    FeatureFrame frame;
    frame.utime = utime;
    frame.width = 640, frame.height = 480;
    frame.fx = frame.fy = 500, frame.cx = 319.5, frame.cy = 239.5;
    frame.T_robot_camera = T_robot_camera;
    const Eigen::Isometry3d T_camera_world = (T_world_robot * T_robot_camera).inverse();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d p = T_camera_world * points_[i];
      const double u = frame.fx * p.x() / p.z() + frame.cx, v = frame.fy * p.y() / p.z() + frame.cy;
      if (p.z() < 0.3 || u < 0 || v < 0 || u > 639 || v > 479) continue;
      Feature feature;
      feature.x = static_cast<float>(u);
      feature.y = static_cast<float>(v);
      feature.laplacian = 1;
      feature.kind = MeasurementKind::point;
      feature.point = p.cast<float>();
      feature.depth_sigma = 0.005f;
      feature.descriptor = descriptors_[i];
      frame.features.push_back(feature);
    }
    return frame;
  }

 private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<Descriptor> descriptors_;
};

const Utime start_time = 1'000'000'000;
Utime time_of(int i) {
  return start_time + static_cast<Utime>(i) * 33'333;
}

Eigen::Isometry3d pose_of(int i) {
  const double s = 1e-6 * static_cast<double>(time_of(i) - start_time);
  Vector6d twist;
  twist << 0.4, 0.1, 0.05, 0.02, 0.05, 0.5;
  return se3_exp(s * twist);
}

FeatureFrame blind(int i) {
  FeatureFrame frame = Room(0).see(pose_of(i), time_of(i), optical_axes());
  return frame;
}

bool near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double tolerance) {
  return se3_log(a.inverse() * b).norm() < tolerance;
}

TEST(VisualOdometry, FollowsTheRobotFrameWhateverTheMount) {
  const Room room(1500);
  Vector6d mount;
  mount << 0.1, -0.05, 1.2, 0.05, 0.35, -0.1;
  for (const Eigen::Isometry3d& T_robot_camera :
       {optical_axes(), Eigen::Isometry3d(se3_exp(mount) * optical_axes())}) {
    VisualOdometry odometry({}, Random(1));
    int keyframes = 0;
    for (int i = 0; i < 300; ++i) {
      const auto sample = odometry.update(room.see(pose_of(i), time_of(i), T_robot_camera));
      ASSERT_TRUE(sample);
      EXPECT_TRUE(sample->visual);
      EXPECT_EQ(sample->utime, time_of(i));
      ASSERT_EQ(odometry.report().status, VisualStatus::tracking) << i << ": " << odometry.report().reason;
      ASSERT_TRUE(near(sample->T_odom_robot, pose_of(i), 1e-4)) << i;
      keyframes += odometry.report().new_keyframe;
    }
    EXPECT_GT(keyframes, 10) << "4 m and 5 rad pass the keyframe's limits often";
    EXPECT_LT(keyframes, 60) << "a keyframe serves many frames";
  }
}

// The same camera on another arm: what it does not know is the same, seen from the robot.
TEST(VisualOdometry, TheCovarianceIsTheRobotsWhateverTheMount) {
  const Room room(1500);
  VisualOdometrySettings settings;
  settings.stamp_sigma = 1e-9;
  settings.translation_floor = settings.rotation_floor = 1e-6;
  const auto covariance = [&](const Eigen::Isometry3d& T_robot_camera) {
    VisualOdometry odometry(settings, Random(1));
    Matrix6d result = Matrix6d::Zero();
    for (int i = 0; i < 2; ++i) {
      const Eigen::Isometry3d T_world_robot = pose_of(i) * optical_axes() * T_robot_camera.inverse();
      result = odometry.update(room.see(T_world_robot, time_of(i), T_robot_camera))->covariance;
    }
    return result;
  };
  const Matrix6d of_camera = covariance(Eigen::Isometry3d::Identity());
  const Eigen::Isometry3d T_robot_camera = se3_exp((Vector6d() << 0.1, -0.5, 1.2, 0.5, 1.2, -0.4).finished());
  const Matrix6d A = adjoint(T_robot_camera);
  EXPECT_GT(of_camera(0, 0), 1e-9);
  EXPECT_TRUE(covariance(T_robot_camera).isApprox(A * of_camera * A.transpose(), 1e-3));
}

TEST(VisualOdometry, AnImagesTimeThatMayBeWrongMakesTheWayUncertain) {
  const Room room(1500);
  const auto covariance = [&](double stamp_sigma) {
    VisualOdometrySettings settings;
    settings.stamp_sigma = stamp_sigma;
    VisualOdometry odometry(settings, Random(1));
    odometry.update(room.see(pose_of(0), time_of(0), optical_axes()));
    return odometry.update(room.see(pose_of(1), time_of(1), optical_axes()))->covariance;
  };
  const double seconds = 1e-6 * static_cast<double>(time_of(1) - time_of(0));
  const Vector6d shift = 0.1 / seconds * se3_log(pose_of(0).inverse() * pose_of(1));
  EXPECT_TRUE((covariance(0.1) - covariance(1e-9)).isApprox(shift * shift.transpose(), 0.01));
}

TEST(VisualOdometry, PredictsThroughBlindFramesAndSaysSo) {
  const Room room(1500);
  VisualOdometry odometry({}, Random(1));
  MotionBuffer buffer;
  for (int i = 0; i < 40; ++i) {
    const bool sees = i < 20 || i >= 26;
    const auto sample = odometry.update(sees ? room.see(pose_of(i), time_of(i), optical_axes()) : blind(i));
    ASSERT_TRUE(sample);
    buffer.add(*sample);
    EXPECT_EQ(odometry.report().status, sees ? VisualStatus::tracking : VisualStatus::degraded) << i;
    EXPECT_EQ(odometry.report().reason.empty(), sees);
    EXPECT_TRUE(near(sample->T_odom_robot, pose_of(i), 1e-3)) << "constant velocity, frame " << i;
  }
  const auto width = [&](int from, int to) {
    const auto motion = buffer.between(time_of(from), time_of(to));
    EXPECT_TRUE(motion);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(motion->covariance).eigenvalues()[0], 0);
    return std::sqrt(motion->covariance(0, 0));
  };
  const double tracked = width(18, 19);
  EXPECT_GT(width(24, 25), 5 * tracked);
  EXPECT_GT(width(25, 26), 5 * tracked) << "the step back holds the prediction's error";
  EXPECT_LT(width(30, 31), 2 * tracked);
}

TEST(VisualOdometry, LostForLongStopsAndGoesOnFromThere) {
  const Room room(1500);
  VisualOdometry odometry({}, Random(1));
  for (int i = 0; i < 10; ++i) odometry.update(room.see(pose_of(i), time_of(i), optical_axes()));
  for (int i = 10; i < 40; ++i) odometry.update(blind(i));
  EXPECT_EQ(odometry.report().status, VisualStatus::lost);
  const MotionSample lost = *odometry.update(blind(40));
  // Another part of the room: nothing of the keyframe is seen again.
  const Eigen::Isometry3d elsewhere = planar_pose(0, 0, 3);
  std::optional<MotionSample> sample;
  for (int i = 41; i < 60; ++i) {
    sample = odometry.update(room.see(elsewhere * pose_of(i - 41), time_of(i), optical_axes()));
  }
  ASSERT_TRUE(sample);
  EXPECT_EQ(odometry.report().status, VisualStatus::tracking) << odometry.report().reason;
  EXPECT_TRUE(near(lost.T_odom_robot * pose_of(18), sample->T_odom_robot, 1e-3));
  EXPECT_GT(sample->covariance(0, 0), 1.0) << "the way between is unknown by metres";
}

TEST(VisualOdometry, RejectsMotionThatIsTooFast) {
  const Room room(1500);
  VisualOdometry odometry({}, Random(1));
  odometry.update(room.see(pose_of(0), time_of(0), optical_axes()));
  odometry.update(room.see(planar_pose(0.5, 0, 0), time_of(1), optical_axes()));  // 15 m/s
  EXPECT_EQ(odometry.report().status, VisualStatus::degraded);
  EXPECT_THAT(odometry.report().reason, HasSubstr("max_speed"));
}

// Tiles, 9 x 9 of them, straight below the camera. Three fifths look in the second picture like those a
// quarter turn on.
FeatureFrame tiles(Utime utime, bool turned) {
  constexpr int reach = 4;
  std::map<std::pair<int, int>, Descriptor> looks;
  Random random(5);
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (auto& byte : looks[{x, y}]) byte = static_cast<std::uint8_t>(random.below(256));
  FeatureFrame frame = blind(0);
  frame.utime = utime;
  int ring = 0;  // four tiles that turn into each other
  for (int x = 1; x <= reach; ++x)
    for (int y = 0; y <= reach; ++y, ++ring)
      for (int quarter = 0, u = x, v = y; quarter < 4; ++quarter, std::tie(u, v) = std::pair(-v, u)) {
        Feature feature;
        feature.point = Eigen::Vector3f(0.25f * static_cast<float>(u), 0.25f * static_cast<float>(v), 2);
        feature.x = static_cast<float>(frame.cx + frame.fx * 0.125 * u);
        feature.y = static_cast<float>(frame.cy + frame.fy * 0.125 * v);
        feature.laplacian = 1;
        feature.kind = MeasurementKind::point;
        feature.depth_sigma = 0.005f;
        feature.descriptor = turned && ring % 5 < 3 ? looks[{-v, u}] : looks[{u, v}];
        frame.features.push_back(feature);
      }
  return frame;
}

TEST(VisualOdometry, BelievesWhatTheLastMotionLedToWhereMoreLooksLikeAnotherMotion) {
  VisualOdometry odometry({}, Random(1));
  for (int i = 0; i < 4; ++i) odometry.update(tiles(time_of(10 * i), false));
  const auto sample = odometry.update(tiles(time_of(40), true));
  ASSERT_TRUE(sample);
  EXPECT_EQ(odometry.report().status, VisualStatus::tracking);
  EXPECT_TRUE(near(sample->T_odom_robot, Eigen::Isometry3d::Identity(), 0.01)) << "not a quarter turn";

  VisualOdometrySettings blind_to_it;
  blind_to_it.expected_within = 0;
  VisualOdometry other(blind_to_it, Random(1));
  for (int i = 0; i < 4; ++i) other.update(tiles(time_of(10 * i), false));
  EXPECT_NEAR(rotation_angle(other.update(tiles(time_of(40), true))->T_odom_robot), M_PI / 2, 0.01)
      << "most matches say so";
}

TEST(VisualOdometry, WaitsForDepthAndStartsAnewWhenTimeGoesBack) {
  const Room room(1500);
  VisualOdometry odometry({}, Random(1));
  EXPECT_FALSE(odometry.update(blind(0)));
  FeatureFrame no_depth = room.see(pose_of(1), time_of(1), optical_axes());
  for (Feature& feature : no_depth.features) {
    feature.kind = MeasurementKind::bearing;
    feature.point.setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  EXPECT_FALSE(odometry.update(no_depth));
  EXPECT_EQ(odometry.report().status, VisualStatus::waiting);
  EXPECT_THAT(odometry.report().reason, HasSubstr("0 features with depth"));
  for (int i = 2; i < 12; ++i) ASSERT_TRUE(odometry.update(room.see(pose_of(i), time_of(i), optical_axes())));
  EXPECT_FALSE(odometry.update(room.see(pose_of(11), time_of(11), optical_axes()))) << "repeated stamp";
  const auto again = odometry.update(room.see(pose_of(5), time_of(5), optical_axes()));
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->T_odom_robot.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_EQ(again->covariance, Matrix6d::Zero());
}

TEST(VisualOdometry, SettingsAreChecked) {
  VisualOdometrySettings settings;
  settings.max_speed = 0;
  EXPECT_THROW(VisualOdometry(settings, Random(1)), std::invalid_argument);
  settings = {};
  settings.keyframe_inlier_ratio = 1.5;
  EXPECT_THROW(VisualOdometry(settings, Random(1)), std::invalid_argument);
}

// A real hand-held Kinect, 4 s: tracks every frame, near the truth, the same for each run.
TEST(VisualOdometry, FollowsARecordedCamera) {
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  testing::TumRecording recording(recording_path("tum_fr1_rpy"));
  constexpr std::size_t frames = 120;
  ASSERT_GE(recording.size(), frames);
  VisualOdometry odometry({}, Random(1)), again({}, Random(1));
  Trajectory estimate;
  int tracked = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const FeatureFrame frame = recording.features(i);
    const auto sample = odometry.update(frame);
    ASSERT_TRUE(sample);
    ASSERT_EQ(sample->T_odom_robot.matrix(), again.update(frame)->T_odom_robot.matrix()) << "frame " << i;
    ASSERT_TRUE(sample->covariance.allFinite());
    estimate.push_back({sample->utime, sample->T_odom_robot * frame.T_robot_camera});
    tracked += odometry.report().status == VisualStatus::tracking;
  }
  const TrajectoryReport report = evaluate(read_tum(recording_path("tum_fr1_rpy/groundtruth.txt")), estimate);
  std::cout << "fr1_rpy, " << frames << " frames: ATE " << report.absolute.translation.rmse << " m over "
            << report.truth_length << " m, RPE " << report.per_second.translation.rmse << " m and "
            << report.per_second.rotation.rmse << " rad per second, tracked " << tracked << "\n";
  EXPECT_GE(tracked, 115);
  EXPECT_LT(report.absolute.translation.rmse, 0.10);
  EXPECT_LT(report.per_second.rotation.rmse, 0.10);
  // The recording turns and hardly moves: its position says little, so that the turning must count.
  Trajectory still = estimate;
  for (StampedPose& pose : still) pose.T_world_body.setIdentity();
  const TrajectoryReport standing = evaluate(read_tum(recording_path("tum_fr1_rpy/groundtruth.txt")), still);
  EXPECT_LT(report.per_second.rotation.rmse, 0.2 * standing.per_second.rotation.rmse);
  std::cout << "standing still would have ATE " << standing.absolute.translation.rmse << " m, RPE "
            << standing.per_second.translation.rmse << " m and " << standing.per_second.rotation.rmse
            << " rad per second\n";
}

// What an hour of darkness leaves open is no error of the steps after it.
TEST(VisualOdometry, AfterALongDarknessItsStepsAreAsSureAsBefore) {
  const Room room(1500);
  VisualOdometry odometry({}, Random(1));
  MotionBuffer buffer;
  Utime later = 0;
  for (int i = 0; i < 40; ++i) {
    if (i == 20)  // twice a second
      for (int k = 0; k < 7200; ++k) {
        FeatureFrame dark = blind(i);
        dark.utime += later += 500'000;
        buffer.add(*odometry.update(dark));
      }
    FeatureFrame frame = room.see(pose_of(i), time_of(i), optical_axes());
    frame.utime += later;
    buffer.add(*odometry.update(frame));
  }
  const auto covariance = [&](int i, Utime shift) {
    return buffer.between(time_of(i) + shift, time_of(i + 1) + shift)->covariance;
  };
  for (int i = 35; i < 39; ++i) {
    const Matrix6d now = covariance(i, later);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(now).eigenvalues()[0], 0) << i;
    EXPECT_LT(now.diagonal().head<3>().maxCoeff(), 1e-4) << i;
  }
}

}  // namespace
}  // namespace lcmslam

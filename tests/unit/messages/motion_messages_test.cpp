#include <lcmslam/messages/motion_messages.hpp>

#include <gmock/gmock.h>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include "tests/unit/messages/error_of.hpp"
#include "tests/unit/messages/samples.hpp"

namespace lcmslam {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

const double not_a_number = std::nan("");

TEST(MotionMessages, EncodersComeBackAsTheyWere) {
  Random random(1);
  const Encoders encoders = testing::some_encoders(random);
  encoders_t message = to_message(encoders);
  set_origin(message, {12, 34});
  const Encoders back = from_message(message);
  EXPECT_EQ(back.utime, encoders.utime);
  EXPECT_EQ(back.seq, 12);
  ASSERT_EQ(back.wheels.size(), encoders.wheels.size());
  for (std::size_t i = 0; i < back.wheels.size(); ++i) {
    const Wheel &a = back.wheels[i], &b = encoders.wheels[i];
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.roller_angle, b.roller_angle);
    EXPECT_EQ(a.angle, b.angle);
    EXPECT_EQ(a.steering, b.steering);
  }
}

TEST(MotionMessages, ImpossibleEncodersAreRefusedByName) {
  Random random(2);
  const encoders_t good = to_message(testing::some_encoders(random));
  const auto error_with = [&](auto change) {
    encoders_t message = good;
    change(message);
    return error_of([&] { from_message(message); });
  };
  EXPECT_EQ(error_with([](auto&) {}), "");
  EXPECT_THAT(error_with([](auto& m) { m.wheels.resize(1), m.n_wheels = 1; }), HasSubstr("n_wheels"));
  EXPECT_THAT(error_with([](auto& m) { m.wheels.resize(65, m.wheels[0]), m.n_wheels = 65; }),
              HasSubstr("n_wheels"));
  EXPECT_THAT(error_with([](auto& m) { m.wheels[1].x = not_a_number; }), HasSubstr("wheel x"));
  EXPECT_THAT(error_with([](auto& m) { m.wheels[1].y = 1e9; }), HasSubstr("wheel y"));
  EXPECT_THAT(error_with([](auto& m) { m.wheels[2].radius = 0; }), HasSubstr("wheel radius"));
  EXPECT_THAT(error_with([](auto& m) { m.wheels[2].roller_angle = M_PI / 2; }),
              HasSubstr("wheel roller_angle"));
  EXPECT_THAT(error_with([](auto& m) { m.wheels[3].angle = INFINITY; }), HasSubstr("wheel angle"));
  EXPECT_THAT(error_with([](auto& m) { m.wheels[0].steering = -INFINITY; }), HasSubstr("wheel steering"));
}

TEST(MotionMessages, OdometryComesBackAsItWas) {
  Random random(3);
  for (const std::string source : {"wheels", "visual"}) {
    MotionSample sample;
    sample.utime = 42;
    sample.T_odom_robot = testing::some_pose(random);
    sample.covariance = testing::some_covariance(random);
    const odometry_t message = to_message(sample, source);
    EXPECT_EQ(message.frame, "odom");
    EXPECT_EQ(message.child_frame, "robot");
    const MotionSample back = from_message(message);
    EXPECT_EQ(back.utime, 42);
    EXPECT_TRUE(back.T_odom_robot.isApprox(sample.T_odom_robot, 1e-12));
    EXPECT_TRUE(back.covariance.isApprox(sample.covariance, 1e-12));
    EXPECT_EQ(back.visual, source == "visual");
  }
}

TEST(MotionMessages, ImpossibleOdometryIsRefusedByName) {
  Random random(4);
  MotionSample sample;
  sample.covariance = testing::some_covariance(random);
  const odometry_t good = to_message(sample, "wheels");
  const auto error_with = [&](auto change) {
    odometry_t message = good;
    change(message);
    return error_of([&] { from_message(message); });
  };
  EXPECT_EQ(error_with([](auto&) {}), "");
  EXPECT_THAT(error_with([](auto& m) { m.T_odom_robot.quat[3] = not_a_number; }),
              HasSubstr("T_odom_robot: quaternion"));
  EXPECT_THAT(error_with([](auto& m) { std::fill_n(m.T_odom_robot.quat, 4, 0.0); }), HasSubstr("quaternion"));
  EXPECT_THAT(error_with([](auto& m) { m.T_odom_robot.trans[0] = not_a_number; }), HasSubstr("T_odom_robot"));
  EXPECT_THAT(error_with([](auto& m) { m.T_odom_robot.trans[0] = 1e7; }), HasSubstr("10000000"));
  EXPECT_THAT(error_with([](auto& m) { m.covariance[35] = not_a_number; }), HasSubstr("covariance"));
  EXPECT_THAT(error_with([](auto& m) { m.covariance[7] = -1e-3; }), HasSubstr("a variance is negative"));
}

TEST(MotionMessages, PoseEstimateCarriesPoseAndCovariance) {
  Random random(5);
  const Eigen::Isometry3d T = testing::some_pose(random);
  const Matrix6d covariance = testing::some_covariance(random);
  const pose_estimate_t m = make_pose_estimate(77, T, covariance);
  EXPECT_EQ(m.utime, 77);
  EXPECT_TRUE(from_message(m.T_map_robot, "T_map_robot").isApprox(T, 1e-12));
  EXPECT_EQ(m.covariance[1 * 6 + 4], covariance(1, 4));  // row-major
  EXPECT_TRUE(covariance_from_message(m.covariance, "covariance").isApprox(covariance, 1e-12));
}

}  // namespace
}  // namespace lcmslam

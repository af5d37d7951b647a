#include <lcmslam/odometry/wheel_odometry.hpp>

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <limits>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/odometry/wheel_kinematics.hpp>
#include "tests/unit/odometry/simulated_bases.hpp"

namespace lcmslam {
namespace {

using testing::Base;
using testing::expect_near;
using ::testing::HasSubstr;

Eigen::Isometry3d odometry_after(Base base, const PlanarTwist& twist, double seconds, int messages) {
  WheelOdometry odometry;
  testing::steer(base, twist);
  EXPECT_TRUE(odometry.update(base.encoders)->T_odom_robot.isApprox(Eigen::Isometry3d::Identity()));
  MotionSample sample;
  for (int i = 0; i < messages; ++i) {
    testing::drive(base, twist, seconds / messages);
    sample = *odometry.update(base.encoders);
    EXPECT_LT(odometry.residual(), 1e-12) << base.name;
    EXPECT_NEAR(odometry.twist().vx, twist.vx, 1e-9) << base.name;
    EXPECT_NEAR(odometry.twist().vy, twist.vy, 1e-9) << base.name;
    EXPECT_NEAR(odometry.twist().w, twist.w, 1e-9) << base.name;
  }
  EXPECT_EQ(sample.utime, base.encoders.utime);
  EXPECT_FALSE(sample.visual);
  return sample.T_odom_robot;
}

TEST(WheelOdometry, StraightTurnOnTheSpotAndQuarterCircle) {
  for (const Base& base : testing::all_bases()) {
    expect_near(odometry_after(base, {0.5, 0, 0}, 4, 200), planar_pose(2, 0, 0), 1e-9, base.name);
    expect_near(odometry_after(base, {-0.5, 0, 0}, 4, 200), planar_pose(-2, 0, 0), 1e-9, base.name);
    expect_near(odometry_after(base, {0, 0, 0.5}, M_PI, 200), planar_pose(0, 0, M_PI / 2), 1e-5, base.name);
    // A circle of 2 m, left turn: a quarter of it ends at (2, 2).
    expect_near(odometry_after(base, {M_PI / 2, 0, M_PI / 4}, 2, 100), planar_pose(2, 2, M_PI / 2), 1e-9,
                base.name);
  }
}

// Wheels that are larger than stated, and farther apart: the calibrated odometry is the true way.
TEST(WheelOdometry, CalibratedRadiiAndTrackCorrectTheWay) {
  const auto after = [](const PlanarTwist& twist, double seconds) {
    WheelOdometrySettings settings;
    settings.radius_factors = {1.02, 1.02};
    settings.layout_factor = 1.05;
    WheelOdometry odometry(settings);
    Base base = testing::all_bases().front();
    EXPECT_EQ(base.encoders.wheels.size(), 2u);
    odometry.update(base.encoders);
    MotionSample sample;
    for (int i = 0; i < 100; ++i) {
      testing::drive(base, twist, seconds / 100);
      sample = *odometry.update(base.encoders);
    }
    return sample.T_odom_robot;
  };
  expect_near(after({0.5, 0, 0}, 4), planar_pose(2 * 1.02, 0, 0), 1e-9, "straight");
  expect_near(after({0, 0, 0.5}, 2), planar_pose(0, 0, 1.02 / 1.05), 1e-5, "on the spot");

  WheelOdometrySettings settings;
  settings.radius_factors = {1, 1, 1};
  WheelOdometry odometry(settings);
  EXPECT_THROW(odometry.update(testing::all_bases().front().encoders), std::invalid_argument);
}

TEST(WheelOdometry, SidewaysOnBasesThatCan) {
  for (const Base& base : testing::all_bases()) {
    if (!base.sideways) continue;
    expect_near(odometry_after(base, {0, 0.3, 0}, 5, 250), planar_pose(0, 1.5, 0), 1e-9, base.name);
    expect_near(odometry_after(base, {0.3, -0.4, 0}, 5, 250), planar_pose(1.5, -2, 0), 1e-9, base.name);
  }
}

TEST(WheelOdometry, IsExactOnRandomArcs) {
  Random random(11);
  for (int trial = 0; trial < 100; ++trial) {
    for (const Base& base : testing::all_bases()) {
      const PlanarTwist twist{random.uniform(-1, 1), base.sideways ? random.uniform(-1, 1) : 0,
                              random.uniform(-1, 1)};
      expect_near(odometry_after(base, twist, 2, 8), testing::arc(twist, 2), 1e-9, base.name);
    }
  }
}

TEST(WheelOdometry, LostMessagesCostNothing) {
  for (Base base : testing::all_bases()) {
    const PlanarTwist twist{0.4, base.sideways ? 0.2 : 0, 0.7};
    testing::steer(base, twist);
    WheelOdometry all, few;
    all.update(base.encoders);
    few.update(base.encoders);
    MotionSample every, last;
    for (int i = 0; i < 100; ++i) {
      testing::drive(base, twist, 0.02);
      every = *all.update(base.encoders);
      if (i == 17 || i == 99) last = *few.update(base.encoders);
    }
    expect_near(every.T_odom_robot, last.T_odom_robot, 1e-9, base.name);
    const double difference = (every.covariance - last.covariance).cwiseAbs().maxCoeff();
    EXPECT_LT(difference, 0.01 * every.covariance.cwiseAbs().maxCoeff()) << base.name;
  }
}

TEST(WheelOdometry, SteeringIsTakenHalfWayByTheShortWay) {
  Base base = testing::steered_base();
  for (Wheel& wheel : base.encoders.wheels) wheel.steering = M_PI - 0.1;
  std::vector<Wheel> after = base.encoders.wheels;
  for (Wheel& wheel : after) {
    wheel.steering = -M_PI + 0.1;
    wheel.angle += 1;
  }
  const WheelFit fit = fit_motion(base.encoders.wheels, after);
  EXPECT_TRUE(fit.motion.isApprox(Eigen::Vector3d(-0.08, 0, 0), 1e-9)) << fit.motion.transpose();
}

TEST(WheelOdometry, ResidualShowsASlippingWheelAndWidensTheCovariance) {
  Base base = testing::steered_base();
  WheelOdometry odometry, undisturbed;
  for (WheelOdometry* o : {&odometry, &undisturbed}) o->update(base.encoders);
  testing::drive(base, {0.5, 0, 0}, 0.02);
  const MotionSample without = *undisturbed.update(base.encoders);
  base.encoders.wheels[0].angle += 0.05 / base.encoders.wheels[0].radius;
  const WheelFit fit = fit_motion(testing::steered_base().encoders.wheels, base.encoders.wheels);
  const MotionSample with = *odometry.update(base.encoders);
  EXPECT_GT(odometry.residual(), 0.005);
  EXPECT_LT(undisturbed.residual(), 1e-12);
  for (const int axis : {0, 1, 5}) {
    EXPECT_GT(with.covariance(axis, axis), 2 * without.covariance(axis, axis)) << "axis " << axis;
  }
  // Not only by the longer way: what the wheels contradict each other stands in it.
  EXPECT_GT(fit.covariance(0, 0), 1e-6);
  EXPECT_GE(with.covariance(0, 0), fit.covariance(0, 0));
  EXPECT_GE(with.covariance(5, 5), fit.covariance(2, 2));
}

// A differential base cannot drive sideways; one that steers or has rollers can, and errs so.
TEST(WheelOdometry, KnowsWhetherTyresHoldTheBaseSideways) {
  const WheelNoise noise;
  for (Base base : testing::all_bases()) {
    WheelOdometry odometry;
    odometry.update(base.encoders);
    const PlanarTwist twist{0.5, base.sideways ? 0.02 : 0, 0};
    testing::steer(base, twist);
    odometry.update(base.encoders);
    MotionSample sample;
    for (int i = 0; i < 100; ++i) {  // a metre
      testing::drive(base, twist, 0.02);
      sample = *odometry.update(base.encoders);
    }
    // The heading's error leads it aside, too: take what is independent of that.
    const Matrix6d& S = sample.covariance;
    const double aside = std::sqrt(S(1, 1) - S(1, 5) * S(1, 5) / S(5, 5));
    EXPECT_GT(aside, base.sideways ? noise.translation_drift : noise.side_drift) << base.name;
    EXPECT_LT(aside, base.sideways ? 0.02 : 0.006) << base.name;
    EXPECT_GT(S(0, 0), noise.translation_drift * noise.translation_drift) << base.name;
  }
}

// The robot's frame half a metre ahead of the axle: what errs in heading swings it aside, and no tyre holds
// it there.
TEST(WheelOdometry, AWrongHeadingSwingsABodyAboutItsAxle) {
  constexpr double ahead = 0.5;
  Encoders encoders;
  encoders.sender = 1;
  for (const double y : {-0.3, 0.3}) {
    Wheel wheel;
    wheel.x = -ahead, wheel.y = y, wheel.radius = 0.1;
    encoders.wheels.push_back(wheel);
  }
  for (const double turn : {0.2, M_PI / 2}) {
    WheelOdometry odometry;
    Encoders now = encoders;
    now.utime = 1'000'000;
    odometry.update(now);
    MotionSample sample;
    for (int i = 0; i < 20; ++i) {  // on the spot
      now.utime += 50'000;
      for (Wheel& wheel : now.wheels) wheel.angle -= turn / 20 * wheel.y / wheel.radius;
      sample = *odometry.update(now);
    }
    EXPECT_NEAR(yaw(sample.T_odom_robot), turn, 1e-9);
    const std::array<int, 3> free{0, 1, 5};
    const Eigen::Matrix3d S = sample.covariance(free, free);
    const double s = std::sqrt(S(2, 2));
    // A sigma of heading too much, all of it about the axle, at the turn's end or on the way.
    const Eigen::Vector3d e(0, ahead * s, s);
    EXPECT_LT(e.dot(S.llt().solve(e)), 4) << turn;
    EXPECT_GT(std::sqrt(S(1, 1)), 0.9 * ahead * s) << turn;
  }
}

// How much a tyre's side counts is a matter of taste; what the wheels tell of the motion is not.
TEST(WheelOdometry, AnyWeightOfSideSlipGivesTheMotionOfWheelsThatDoNotSlip) {
  for (const double weight : {1e-6, 9e-5, 1., 2e4, 1e6}) {
    WheelOdometrySettings settings;
    settings.side_slip_weight = weight;
    for (Base base : testing::all_bases()) {
      WheelOdometry odometry(settings);
      const PlanarTwist twist{0.5, 0, base.sideways ? 0 : 0.3};
      testing::steer(base, twist);
      odometry.update(base.encoders);
      testing::drive(base, twist, 0.1);
      const MotionSample sample = *odometry.update(base.encoders);
      EXPECT_TRUE(sample.T_odom_robot.isApprox(
          se3_exp((Vector6d() << 0.05, 0, 0, 0, 0, 0.1 * twist.w).finished()), 1e-6))
          << base.name << ", weight " << weight;
    }
  }
}

TEST(WheelOdometry, EveryIncrementHasAPositiveDefiniteCovariance) {
  Random random(5);
  for (Base base : testing::all_bases()) {
    WheelOdometry odometry;
    MotionBuffer buffer;
    buffer.add(*odometry.update(base.encoders));
    for (int i = 0; i < 300; ++i) {
      const bool rest = i / 50 % 2 == 1;
      const PlanarTwist twist{rest ? 0 : random.uniform(-0.5, 0.5), 0, rest ? 0 : random.uniform(-1, 1)};
      const Utime before = base.encoders.utime;
      testing::drive(base, twist, 0.02);
      ASSERT_TRUE(buffer.add(*odometry.update(base.encoders)));
      const auto motion = buffer.between(before, base.encoders.utime);
      ASSERT_TRUE(motion);
      const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(motion->covariance);
      EXPECT_GT(solver.eigenvalues()[0], 0) << base.name << ", message " << i;
    }
  }
}

// The roller on the ground turns across its axis; along it the contact goes with the wheel.
TEST(WheelOdometry, RollersOfAnyAngle) {
  for (const double roller : {0.3, M_PI / 4, 1.2}) {
    Encoders encoders;
    const Eigen::Vector3d speed(0.4, -0.3, 0.5);  // vx, vy, w
    for (const auto& [x, y, sign] : {std::tuple(0.3, 0.2, -1), std::tuple(0.3, -0.2, 1),
                                     std::tuple(-0.3, 0.2, 1), std::tuple(-0.3, -0.2, -1)})
      encoders.wheels.push_back(testing::make_wheel(x, y, 0.1, sign * roller));
    WheelOdometry odometry;
    odometry.update(encoders);
    constexpr double seconds = 0.02;
    for (Wheel& wheel : encoders.wheels) {
      const Eigen::Vector2d contact(speed.x() - speed.z() * wheel.y, speed.y() + speed.z() * wheel.x);
      const Eigen::Vector2d across(-std::sin(wheel.roller_angle), std::cos(wheel.roller_angle));
      Eigen::Matrix2d A;  // contact = rolled * (1, 0) + turned by the roller * across
      A << Eigen::Vector2d::UnitX(), across;
      wheel.angle = A.inverse().row(0).dot(contact) * seconds / wheel.radius;
    }
    encoders.utime += 20'000;
    odometry.update(encoders);
    EXPECT_NEAR(odometry.twist().vx, speed.x(), 1e-9) << roller;
    EXPECT_NEAR(odometry.twist().vy, speed.y(), 1e-9) << roller;
    EXPECT_NEAR(odometry.twist().w, speed.z(), 1e-9) << roller;
  }
}

std::string error_of(const Encoders& encoders, WheelOdometry odometry = WheelOdometry()) {
  try {
    odometry.update(encoders);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(WheelOdometry, WheelsThatDoNotDetermineTheMotionAreAnError) {
  EXPECT_THAT(error_of({0, 0, 0, {}}), HasSubstr("at least two"));
  EXPECT_THAT(error_of({0, 0, 0, {testing::make_wheel(0, 0.2, 0.1)}}), HasSubstr("at least two"));
  // All in one place: nothing is known of the heading.
  EXPECT_THAT(error_of({0, 0, 0, {testing::make_wheel(0, 0, 0.1), testing::make_wheel(0, 0, 0.1)}}),
              HasSubstr("do not determine"));
  // Two mecanum wheels: two equations for three unknowns.
  EXPECT_THAT(
      error_of({0, 0, 0, {testing::make_wheel(0, 0.2, 0.1, 0.7), testing::make_wheel(0, -0.2, 0.1, 0.7)}}),
      HasSubstr("do not determine"));
  // Four rollers alike on a line: forward and sideways cannot be told apart.
  Encoders alike;
  for (const double y : {-0.3, -0.1, 0.1, 0.3}) alike.wheels.push_back(testing::make_wheel(0, y, 0.1, 0.7));
  EXPECT_THAT(error_of(alike), HasSubstr("do not determine"));
}

TEST(WheelOdometry, WrongValuesAreNamedAndLeaveTheStateAlone) {
  Base base = testing::steered_base();
  WheelOdometry odometry;
  odometry.update(base.encoders);
  testing::drive(base, {0.5, 0, 0}, 0.1);

  const auto broken = [&](auto change) {
    Encoders encoders = base.encoders;
    change(encoders);
    return error_of(encoders, odometry);
  };
  EXPECT_THAT(broken([](Encoders& e) { e.wheels[2].angle = std::numeric_limits<double>::quiet_NaN(); }),
              HasSubstr("wheel 2: angle is nan"));
  EXPECT_THAT(broken([](Encoders& e) { e.wheels[1].radius = 0; }), HasSubstr("wheel 1: radius is 0"));
  EXPECT_THAT(broken([](Encoders& e) { e.wheels[0].roller_angle = 1.57; }), HasSubstr("roller_angle"));
  EXPECT_THAT(broken([](Encoders& e) { e.wheels.pop_back(); }),
              HasSubstr("3 wheels, earlier messages had 4"));

  Encoders fewer = base.encoders;
  fewer.wheels.pop_back();
  EXPECT_THROW(odometry.update(fewer), std::invalid_argument);
  expect_near(odometry.update(base.encoders)->T_odom_robot, planar_pose(0.05, 0, 0), 1e-9, "after the error");
}

TEST(WheelOdometry, SettingsAreChecked) {
  WheelOdometrySettings settings;
  settings.side_slip_weight = 0;
  EXPECT_THROW(WheelOdometry{settings}, std::invalid_argument);
  settings = {};
  settings.noise.rotation_scale = -1;
  EXPECT_THROW(WheelOdometry{settings}, std::invalid_argument);
  settings = {};
  settings.noise.flatness = 0;
  EXPECT_THROW(WheelOdometry{settings}, std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

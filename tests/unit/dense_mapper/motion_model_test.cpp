#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include <lcmslam/dense_mapper/motion_prior.hpp>
#include <lcmslam/settings/check.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

const Eigen::Isometry3d start = planar_pose(1, 2, 0.5);
const Vector6d velocity = twist(0.4, 0.1, 0, 0, 0, 0.6);  // per second

TEST(MotionModel, OdometryLeadsWhereItIsKnown) {
  MotionModel model({});
  model.observe(0, start, true);
  Motion motion;
  motion.T_from_to = planar_pose(0.2, 0, 0.1);
  motion.covariance = 1e-4 * Matrix6d::Identity();
  const Prior prior = model.predict(100'000, motion);
  EXPECT_TRUE(prior.T_target_source.isApprox(start * motion.T_from_to, 1e-12));
  const MotionPriorSettings s;
  EXPECT_NEAR(prior.information(0, 0), 1 / (1e-4 + s.floor_translation * s.floor_translation), 1e-6);
  EXPECT_NEAR(prior.information(5, 5), 1 / (1e-4 + s.floor_rotation * s.floor_rotation), 1e-6);
}

// Who is lost for a while does not move farther in one step for it.
TEST(MotionModel, AStepAloneDoesNotKnowOfWhatCameBefore) {
  MotionModel model({});
  model.observe(0, start, true);
  Motion still;
  still.covariance = 1e-4 * Matrix6d::Identity();
  const MotionPriorSettings s;
  for (int i = 1; i <= 50; ++i) {
    model.lose(100'000 * i, still);
    model.observe(100'000 * i, start, false);
  }
  model.be_carried(3);
  const Matrix6d all = model.predict(5'100'000, still).information.inverse();
  const Matrix6d alone = model.predict_step(5'100'000, still).information.inverse();
  EXPECT_GT(all(0, 0), 1);
  EXPECT_NEAR(alone(0, 0), 1e-4 + 0.01 * s.floor_translation * s.floor_translation, 1e-9);
  // Where nobody knows the step it may be any that a robot can do.
  const Matrix6d unknown = model.predict_step(5'300'000, std::nullopt).information.inverse();
  EXPECT_NEAR(unknown(0, 0), 0.15 * 0.15 + s.free_translation * s.free_translation, 1e-9) << "0.5 m/s";
}

// Wheels slip along their way, tyres hold a base sideways: what is added to odometry's covariance keeps its
// shape.
TEST(MotionModel, TheFloorOfAStepLiesAsOdometrysErrorDoes) {
  MotionPriorSettings s;
  s.floor_translation = 0.03;
  const auto variances = [&](double along, double across, double direction) {
    Motion motion;
    motion.T_from_to.translation().x() = 0.05;
    motion.covariance = 1e-8 * Matrix6d::Identity();
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(direction).toRotationMatrix();
    motion.covariance.topLeftCorner<2, 2>() =
        R * Eigen::Vector2d(along * along, across * across).asDiagonal() * R.transpose();
    MotionModel model(s);
    model.observe(0, start, true);
    const Matrix6d told = model.predict(100'000, motion).information.inverse();
    const Eigen::Matrix2d turned_back = R.transpose() * told.topLeftCorner<2, 2>() * R;
    EXPECT_NEAR(turned_back(0, 1), 0, 1e-12);
    EXPECT_NEAR(told(2, 2), 1e-8 + 0.03 * 0.03, 1e-9) << "nothing holds a base's height on a ramp";
    return Eigen::Vector2d(turned_back.diagonal());
  };
  for (const double direction : {0.0, 0.7}) {
    const Eigen::Vector2d held = variances(0.003, 0.001, direction);
    EXPECT_NEAR(held[0], 9e-6 + 0.03 * 0.03, 1e-9);
    EXPECT_NEAR(held[1], 1e-6 + 0.01 * 0.01, 1e-9);
    EXPECT_NEAR(variances(0.003, 0, direction)[1], 0.003 * 0.003, 1e-9) << "a tenth, whatever is claimed";
  }
  EXPECT_NEAR(variances(0, 0, 0)[1], 0.03 * 0.03, 1e-9) << "odometry that tells no error";
}

// Else whoever walks by takes a robot along that stands.
TEST(MotionModel, WheelsThatDoNotTurnDoNotSlip) {
  const MotionPriorSettings s;
  const auto sigma = [&](MotionModel& model, double metres, bool visual = false) {
    Motion motion;
    motion.T_from_to.translation().x() = metres;
    motion.visual = visual;
    return std::sqrt(model.predict(100'000, motion).information.inverse()(0, 0));
  };
  MotionModel model(s);
  model.observe(0, start, true);
  EXPECT_NEAR(sigma(model, 0), 0.1 * s.floor_translation, 1e-9);
  EXPECT_NEAR(sigma(model, 0.0025), 0.5 * s.floor_translation, 1e-9);
  EXPECT_NEAR(sigma(model, 0.02), s.floor_translation, 1e-9);
  EXPECT_NEAR(sigma(model, 0, true), s.floor_translation, 1e-9) << "a camera in the hand has no wheels";
  // Unless somebody pushes it.
  Motion still;
  EXPECT_TRUE(model.is_held(still));
  for (const Prior& prior : {model.predict(100'000, still, Floor::plane, true),
                             model.predict_step(100'000, still, Floor::plane, true)})
    EXPECT_NEAR(std::sqrt(prior.information.inverse()(0, 0)), s.floor_translation, 1e-9);
  still.visual = true;
  EXPECT_FALSE(model.is_held(still));
  EXPECT_FALSE(model.is_held(std::nullopt));
  // Who has driven unseen may have slipped there, and stands now.
  Motion way;
  way.T_from_to.translation().x() = 0.5;
  model.lose(100'000, way);
  EXPECT_NEAR(sigma(model, 0), s.floor_translation, 1e-9);
  model.found();
  EXPECT_NEAR(sigma(model, 0), 0.1 * s.floor_translation, 1e-9);
}

TEST(MotionModel, TheLastVelocityGoesOnForASecondAtMost) {
  MotionModel model({});
  model.observe(0, start, true);
  model.observe(200'000, start * se3_exp(0.2 * velocity), true);
  const Eigen::Isometry3d last = model.T_world_last();
  EXPECT_TRUE(
      model.predict(300'000, std::nullopt).T_target_source.isApprox(last * se3_exp(0.1 * velocity), 1e-9));
  EXPECT_TRUE(
      model.predict(5'000'000, std::nullopt).T_target_source.isApprox(last * se3_exp(velocity), 1e-9));
  // A jump is no motion that goes on.
  model.observe(400'000, planar_pose(9, 9, 0), false);
  EXPECT_TRUE(model.predict(500'000, std::nullopt).T_target_source.isApprox(planar_pose(9, 9, 0), 1e-12));
}

TEST(MotionModel, ARobotThatNobodyWatchesIsAdriftUntilItIsFound) {
  MotionModel model({});
  model.observe(0, start, false);
  model.look_for_gap(900'000, std::nullopt);
  EXPECT_FALSE(model.adrift());
  model.look_for_gap(6'000'000, Motion{});
  EXPECT_FALSE(model.adrift()) << "odometry was there";
  double last_variance = 0;
  for (const Utime utime : {6'000'000, 6'100'000, 6'200'000}) {
    // Odometry that comes back does not know either.
    const auto motion = utime > 6'000'000 ? std::optional(Motion{}) : std::nullopt;
    model.look_for_gap(utime, motion);
    EXPECT_TRUE(model.adrift());
    const double variance = 1 / model.predict(utime, motion).information(0, 0);
    EXPECT_GT(variance, 9);  // m^2, after six seconds
    EXPECT_GT(variance, last_variance);
    last_variance = variance;
    model.observe(utime, start, false);
  }
  model.found();
  EXPECT_FALSE(model.adrift());
  EXPECT_LT(1 / model.predict(6'300'000, std::nullopt).information(0, 0), 0.01);
}

// Frames come, and say nothing of where it is: it may be anywhere after a second, as if none had come.
TEST(MotionModel, ARobotThatIsLostWithoutOdometryIsAdriftInTheEnd) {
  Motion guess;  // of a visual odometry that is lost, too
  guess.visual = true;
  guess.covariance = 0.05 * 0.05 * Matrix6d::Identity();
  for (const auto& motion : {std::optional<Motion>(), std::optional<Motion>(guess)}) {
    SCOPED_TRACE(motion.has_value());
    MotionModel model({});
    model.observe(0, start, true);
    EXPECT_FALSE(model.knows(motion));
    for (int i = 1; i <= 20; ++i) {
      const Utime utime = i * 100'000;
      model.look_for_gap(utime, motion);
      EXPECT_EQ(model.adrift(), i > 10) << i;
      const double sigma = std::sqrt(model.predict(utime, motion).information.inverse()(0, 0));
      EXPECT_GE(sigma, 0.5 * 0.1 * (i - 1)) << "half a metre a second";
      EXPECT_LT(sigma, 0.5 * 0.1 * i + 0.3) << i;
      model.lose(utime, motion);
      model.observe(utime, start, false);
    }
    model.found();
    EXPECT_FALSE(model.adrift());
    EXPECT_LT(model.predict(2'100'000, std::nullopt).information.inverse()(0, 0), 0.01);
  }
}

TEST(MotionModel, NobodyIsAdriftWhoIsLedOrKnowsHowItMoved) {
  Motion tracked;
  tracked.visual = true;
  tracked.covariance = 0.01 * 0.01 * Matrix6d::Identity();
  Motion wheels;
  wheels.covariance = 0.05 * 0.05 * Matrix6d::Identity();
  const std::pair<std::optional<Motion>, bool> cases[] = {
      {tracked, false}, {wheels, false}, {std::nullopt, true}};
  for (const auto& [motion, guided] : cases) {
    MotionModel model({});
    model.observe(0, start, true);
    EXPECT_EQ(model.knows(motion), !guided);
    for (int i = 1; i <= 20; ++i) {
      model.look_for_gap(i * 100'000, motion);
      EXPECT_FALSE(model.adrift()) << i;
      model.lose(i * 100'000, motion, guided);
      model.observe(i * 100'000, start, false);
    }
  }
}

// A heading that nobody has measured for long swings the place around.
TEST(MotionModel, OdometryAloneIsTheLessSureTheLongerItLasts) {
  MotionModel model({});
  model.observe(0, start, true);
  Motion motion;
  motion.T_from_to = planar_pose(1, 0, 0);
  motion.covariance = 1e-4 * Matrix6d::Identity();
  const auto variances = [&] { return Vector6d(model.predict(1, motion).information.inverse().diagonal()); };
  const Vector6d first = variances();
  model.lose(0, motion);
  model.lose(0, std::nullopt);
  const Vector6d second = variances();
  EXPECT_NEAR(second(0) - first(0), 1e-4, 1e-9);
  EXPECT_NEAR(second(1) - first(1), 1e-4 + 1e-4, 1e-9)
      << "of the first motion, and of its heading a metre on";
  EXPECT_NEAR(second(5) - first(5), 1e-4, 1e-9);
  model.found();
  EXPECT_TRUE(variances().isApprox(first, 1e-12));
}

TEST(MotionModel, ADeformedWorldTakesTheRobotAlong) {
  MotionModel model({});
  model.observe(0, start, true);
  model.observe(200'000, start * se3_exp(0.2 * velocity), true);
  const Eigen::Isometry3d before = model.predict(300'000, std::nullopt).T_target_source;
  const Eigen::Isometry3d T = se3_exp(twist(0.1, -0.2, 0, 0, 0, 0.3));
  model.deform(T);
  EXPECT_TRUE(model.predict(300'000, std::nullopt).T_target_source.isApprox(T * before, 1e-9));
}

TEST(MotionModel, ARobotOnTheGroundStaysThere) {
  MotionPriorSettings settings;
  settings.planar = true;
  MotionModel model(settings);
  model.observe(0, planar_pose(1, 2, 0.5) * se3_exp(twist(0, 0, 0.05, 0.02, -0.03, 0)), true);
  const Prior prior = model.predict(100'000, std::nullopt);
  EXPECT_EQ(prior.T_target_source.translation().z(), 0);
  EXPECT_TRUE(prior.T_target_source.isApprox(on_ground(prior.T_target_source), 1e-12));
  EXPECT_NEAR(prior.information(2, 2), 1 / (settings.ground.height * settings.ground.height), 1e-6);

  // On a floor that is level but anywhere motion tells the height, and on a ramp the tilt, too.
  const Prior level = model.predict(100'000, std::nullopt, Floor::level);
  EXPECT_NEAR(level.T_target_source.translation().z(), 0.05, 1e-3);
  EXPECT_LT(off_ground(level.T_target_source).tail<2>().norm(), 1e-12);
  EXPECT_LT(level.information(2, 2), 0.1 * prior.information(2, 2));
  EXPECT_EQ(level.information(3, 3), prior.information(3, 3));
  const Prior free = model.predict(100'000, std::nullopt, Floor::free);
  EXPECT_LT((off_ground(free.T_target_source) - Eigen::Vector3d(0.05, 0.02, -0.03)).norm(), 1e-3);
  EXPECT_LT(free.information(3, 3), 0.1 * prior.information(3, 3));
}

// Wheels that stand say that nothing is uncertain: the floor is all that keeps a prior finite.
TEST(MotionModel, FloorsAreNeverZero) {
  MotionPriorSettings least;
  for (const auto sigma : {&MotionPriorSettings::floor_translation, &MotionPriorSettings::floor_rotation,
                           &MotionPriorSettings::free_translation, &MotionPriorSettings::free_rotation}) {
    MotionPriorSettings zero;
    zero.*sigma = 0;
    EXPECT_THROW(check(zero, "prior"), std::exception);
    least.*sigma = 1e-6;
  }
  EXPECT_NO_THROW(check(least, "prior"));
  for (const bool planar : {false, true}) {
    least.planar = planar;
    MotionModel model(least);
    model.observe(0, start, true);
    for (const auto& motion : {std::optional<Motion>(Motion()), std::optional<Motion>()}) {
      const Matrix6d information = model.predict(100'000, motion).information;
      EXPECT_TRUE(information.allFinite());
      const double sigma = motion ? 1e-7 : 1e-6;  // of wheels that stand a tenth
      EXPECT_NEAR(sigma * sigma * information(0, 0), 1, 1e-6);
    }
  }
}

}  // namespace
}  // namespace lcmslam

#include "procs/odometry/odometry_node.hpp"

#include <gmock/gmock.h>

#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/pose_t.hpp>
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

constexpr double degree = M_PI / 180;

struct Segment {
  double length, turn;                       ///< m, rad driven in truth
  double translation_error, rotation_error;  ///< m, rad of the relative pose
};

class EveryBase : public ::testing::TestWithParam<const char*> {
 protected:
  /// Drives the whole path; errors of odometry over pieces of about a metre.
  static std::vector<Segment> drive(const std::string& base, std::uint64_t seed) {
    const Simulation simulation(testing::kitchen_settings(base, seed));
    testing::TestBus bus;
    bus.add<OdometryNode>();
    for (Utime t = simulation.start(); t <= simulation.end(); t += 20'000)
      bus.deliver("ENCODERS", to_message(simulation.encoders(t)));
    EXPECT_EQ(bus.decode_errors(), 0);
    std::vector<Segment> segments;
    const auto odometry = bus.on<odometry_t>("ODOMETRY");
    std::size_t begin = 0;
    Segment s{};
    for (std::size_t i = 1; i < odometry.size(); ++i) {
      const auto truth = [&](std::size_t k) { return simulation.T_world_robot(odometry[k].utime); };
      const auto estimate = [&](std::size_t k) { return from_message(odometry[k]).T_odom_robot; };
      const Eigen::Isometry3d step = truth(i - 1).inverse() * truth(i);
      s.length += step.translation().norm();
      s.turn += rotation_angle(step);
      if (s.length < 1) continue;
      const Eigen::Isometry3d error =
          (truth(begin).inverse() * truth(i)).inverse() * (estimate(begin).inverse() * estimate(i));
      s.translation_error = error.translation().norm();
      s.rotation_error = rotation_angle(error);
      segments.push_back(s);
      begin = i;
      s = {};
    }
    return segments;
  }
};

TEST_P(EveryBase, FollowsTheTruthWithinThePinnedErrors) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto segments = drive(GetParam(), seed);
    ASSERT_GE(segments.size(), 11U);
    double sum = 0;
    for (const Segment& s : segments) {
      // Three sigma of scale (3 %) and drift (0.5 degree per root metre), and one slip (3 degrees, 5 cm).
      const double rotation = 3 * (0.03 * s.turn + 0.5 * degree * std::sqrt(s.length)) + 3 * degree;
      EXPECT_LT(s.rotation_error, rotation);
      EXPECT_LT(s.translation_error, 3 * (0.03 + 0.01) * s.length + 0.05 + rotation * s.length / 2);
      sum += s.translation_error;
    }
    const double mean = sum / static_cast<double>(segments.size());
    EXPECT_LT(mean, 0.06);
    EXPECT_GT(mean, 0.002);  // wheels without error would hide that the truth is used
  }
}

INSTANTIATE_TEST_SUITE_P(Bases, EveryBase, ::testing::Values("differential", "steered", "mecanum"));

class OdometryNodeTest : public ::testing::Test {
 protected:
  encoders_t encoders(Utime since_start) {
    return to_message(simulation_.encoders(simulation_.start() + since_start));
  }
  Simulation simulation_{testing::kitchen_settings()};
  testing::TestBus bus_;
};

TEST_F(OdometryNodeTest, ChangedNumberOfWheelsIsCountedAndTheOldBaseGoesOn) {
  bus_.add<OdometryNode>();
  bus_.deliver("ENCODERS", encoders(0));
  encoders_t more = encoders(20'000);
  more.wheels.push_back(more.wheels[0]);
  more.n_wheels += 1;
  bus_.deliver("ENCODERS", more);
  EXPECT_EQ(bus_.input(0, "ENCODERS").decode_errors, 1);
  EXPECT_THAT(bus_.input(0, "ENCODERS").last_error, HasSubstr("wheels"));
  EXPECT_EQ(bus_.count("ODOMETRY"), 1U);
  bus_.deliver("ENCODERS", encoders(40'000));
  EXPECT_EQ(bus_.count("ODOMETRY"), 2U);
}

TEST_F(OdometryNodeTest, LateOrRepeatedEncodersChangeNothing) {
  bus_.add<OdometryNode>();
  for (const Utime t : {0, 1'000'000, 2'000'000}) bus_.deliver("ENCODERS", encoders(t));
  bus_.deliver("ENCODERS", encoders(1'980'000));
  bus_.deliver("ENCODERS", encoders(2'000'000));
  EXPECT_EQ(bus_.count("ODOMETRY"), 3U);
  bus_.deliver("ENCODERS", encoders(3'000'000));
  const auto odometry = bus_.on<odometry_t>("ODOMETRY");
  ASSERT_EQ(odometry.size(), 4U);
  const auto step = from_message(odometry[2]).T_odom_robot.inverse() * from_message(odometry[3]).T_odom_robot;
  EXPECT_LT(step.translation().norm(), 0.6);  // and no jump back to the start
}

// A driver that was started again counts from nothing: the robot stays where it was, and how many did is
// told.
TEST_F(OdometryNodeTest, ADriverThatRestartsIsNoMotion) {
  const OdometryNode& node = bus_.add<OdometryNode>();
  const auto of = [&](std::int64_t sender, Utime t, double angle) {
    encoders_t m = encoders(t);
    for (wheel_t& wheel : m.wheels) wheel.angle -= angle;
    set_origin(m, {t / 20'000, sender});
    return m;
  };
  constexpr Utime stops = 4'000'000, starts = 4'800'000;
  const double counted = encoders(starts).wheels[0].angle;
  for (Utime t = 0; t <= stops; t += 20'000) bus_.deliver("ENCODERS", of(11, t, 0));
  const std::size_t before = bus_.count("ODOMETRY");
  for (Utime t = starts; t <= starts + 2'000'000; t += 20'000) bus_.deliver("ENCODERS", of(12, t, counted));
  const auto odometry = bus_.on<odometry_t>("ODOMETRY");
  ASSERT_GT(odometry.size(), before + 50);
  EXPECT_TRUE(from_message(odometry[before])
                  .T_odom_robot.isApprox(from_message(odometry[before - 1]).T_odom_robot, 1e-12));
  EXPECT_EQ(testing::value_of(node, "restarts"), 1);
}

TEST_F(OdometryNodeTest, LogThatLoopsStartsAnewAtTheIdentity) {
  bus_.add<OdometryNode>();
  for (int round = 0; round < 2; ++round)
    for (Utime t = 0; t < 4'000'000; t += 20'000) bus_.deliver("ENCODERS", encoders(t));
  const auto odometry = bus_.on<odometry_t>("ODOMETRY");
  ASSERT_GT(odometry.size(), 200U + 150U);
  ASSERT_GT(odometry[199].utime, odometry[200].utime);
  EXPECT_FALSE(from_message(odometry[199]).T_odom_robot.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(from_message(odometry[200]).T_odom_robot.isApprox(Eigen::Isometry3d::Identity()));
}

TEST_F(OdometryNodeTest, TwistIsTheMotionOverTime) {
  bus_.add<OdometryNode>();
  const Utime a = 3'000'000, b = 3'020'000;
  for (const Utime t : {a, b}) bus_.deliver("ENCODERS", encoders(t));
  const odometry_t m = bus_.on<odometry_t>("ODOMETRY").at(1);
  const double way = from_message(m).T_odom_robot.translation().norm();
  EXPECT_NEAR(std::hypot(m.linear_velocity[0], m.linear_velocity[1]), way / 0.02, 1e-3);
}

TEST_F(OdometryNodeTest, AnotherDriversPoseIsPassedOn) {
  bus_.add<OdometryNode>(ConfigNode::parse("{source: external, external_channel: POSE_BODY}"));
  pose_t pose{};
  pose.orientation[0] = 1;
  double last = 0;
  for (int i = 1; i <= 3; ++i) {
    pose.utime = i * 1'000'000;
    pose.pos[0] = i;
    bus_.deliver("POSE_BODY", pose);
    const odometry_t m = bus_.on<odometry_t>("ODOMETRY").back();
    EXPECT_EQ(m.utime, pose.utime);
    EXPECT_NEAR(m.T_odom_robot.trans[0], i, 1e-12);
    EXPECT_GT(m.covariance[0], last);
    last = m.covariance[0];
  }
  pose.utime += 1'000'000;
  pose.orientation[0] = 3;
  bus_.deliver("POSE_BODY", pose);
  EXPECT_EQ(bus_.decode_errors(), 1);
  EXPECT_EQ(bus_.count("ODOMETRY"), 3U);
}

pose_t resting_pose(Utime utime) {
  pose_t pose{};
  pose.utime = utime;
  pose.orientation[0] = 1;
  return pose;
}

TEST_F(OdometryNodeTest, WithoutASourceAnotherDriversPoseIsTakenWhenNothingBetterComes) {
  const OdometryNode& node = bus_.add<OdometryNode>();
  EXPECT_EQ(node.report().detail, "waits for ENCODERS, TWIST, POSE_BODY or FEATURES");
  for (const Utime t : {10'000'000, 11'000'000, 11'990'000}) bus_.deliver("POSE_BODY", resting_pose(t));
  EXPECT_EQ(bus_.count("ODOMETRY"), 0U);
  bus_.deliver("POSE_BODY", resting_pose(12'000'000));
  ASSERT_EQ(bus_.count("ODOMETRY"), 1U);
  EXPECT_EQ(bus_.on<odometry_t>("ODOMETRY").front().source, "external");
  EXPECT_EQ(node.report().detail, "source external, by what came first");
}

TEST_F(OdometryNodeTest, WheelsThatComeAfterTheChoiceAreNamedAndNotTaken) {
  const OdometryNode& node = bus_.add<OdometryNode>(ConfigNode::parse("{auto_wait: 1}"));
  // Another clock than the wheels': what is not taken must not judge the stamps of what is.
  for (Utime t = 1'000'000; t <= 3'000'000; t += 100'000) bus_.deliver("POSE_BODY", resting_pose(t));
  ASSERT_EQ(bus_.count("ODOMETRY"), 11U);
  bus_.deliver("ENCODERS", encoders(0));
  EXPECT_EQ(bus_.count("ODOMETRY"), 11U);
  EXPECT_THAT(node.report().detail, HasSubstr("ENCODERS came later: odometry.source names it"));
  for (Utime t = 3'100'000; t <= 4'000'000; t += 100'000) bus_.deliver("POSE_BODY", resting_pose(t));
  EXPECT_EQ(bus_.count("ODOMETRY"), 21U);
  EXPECT_EQ(bus_.stamps(0).refused(), 0);
}

TEST_F(OdometryNodeTest, WheelsAreTakenAtOnceWhateverCameBefore) {
  const OdometryNode& node = bus_.add<OdometryNode>();
  bus_.deliver("POSE_BODY", resting_pose(1'700'000'000'000'000));
  for (Utime t = 0; t <= 100'000; t += 20'000) bus_.deliver("ENCODERS", encoders(t));
  EXPECT_EQ(bus_.count("ODOMETRY"), 6U);
  bus_.deliver("POSE_BODY", resting_pose(1'700'000'000'100'000));
  EXPECT_EQ(bus_.count("ODOMETRY"), 6U);
  EXPECT_EQ(bus_.stamps(0).refused(), 0);
  EXPECT_EQ(node.report().detail, "source wheels, by what came first");
}

class ABaseThatSaysOnceThatItStops : public OdometryNodeTest {
 protected:
  static twist_t twist(Utime utime, double v) {
    twist_t m{};
    m.utime = utime;
    m.linear[0] = v;
    return m;
  }
  void look(Utime utime) {
    FeatureFrame frame;
    frame.utime = utime;
    frame.width = 640, frame.height = 480;
    frame.fx = frame.fy = 525;
    bus_.deliver("FEATURES", to_message(frame));
  }
  /// Half a metre a second from 10 to 12 s, told ten times a second, with three images in a second.
  void drive() {
    for (Utime t = 10'000'000; t <= 12'000'000; t += 100'000) {
      bus_.deliver("TWIST", twist(t, t < 12'000'000 ? 0.5 : 0));
      if (t % 300'000 == 0) look(t);
    }
  }
};

TEST_F(ABaseThatSaysOnceThatItStops, StandsAsLongAsItsTwistHolds) {
  for (const char* settings :
       {"{source: twist, twist: {timeout: 5}}", "{auto_wait: 0, twist: {timeout: 5}}"}) {
    bus_ = testing::TestBus();
    bus_.add<OdometryNode>(ConfigNode::parse(settings));
    drive();
    const std::size_t driven = bus_.count("ODOMETRY");
    EXPECT_EQ(driven, 21U) << "while twists come nothing else is told";
    for (const Utime t : {12'300'000, 12'600'000, 15'000'000, 16'900'000}) look(t);
    const auto odometry = bus_.on<odometry_t>("ODOMETRY");
    ASSERT_EQ(odometry.size(), driven + 3) << settings << ", but after a jump of the clock";
    for (std::size_t i = driven - 1; i < odometry.size(); ++i) {
      EXPECT_NEAR(odometry[i].T_odom_robot.trans[0], 1, 1e-9);
      EXPECT_EQ(odometry[i].linear_velocity[0], 0);
    }
    EXPECT_EQ(odometry[driven].utime, 12'300'000);
    EXPECT_EQ(odometry.back().utime, 16'900'000);
    EXPECT_LT(odometry.back().covariance[0] - odometry[driven - 1].covariance[0], 1e-6);
  }
}

TEST_F(ABaseThatSaysOnceThatItStops, NobodyKnowsWhatItDoesAfterTimeout) {
  bus_.add<OdometryNode>(ConfigNode::parse("{source: twist}"));
  drive();
  for (Utime t = 12'300'000; t < 20'000'000; t += 300'000) look(t);
  const odometry_t last = bus_.on<odometry_t>("ODOMETRY").back();
  EXPECT_GT(last.utime, 14'500'000);
  EXPECT_LE(last.utime, 15'000'000);
  EXPECT_NEAR(last.T_odom_robot.trans[0], 1, 1e-9);
  EXPECT_TRUE(std::isnan(last.linear_velocity[0]));
  EXPECT_GT(last.covariance[0], 10);
}

TEST_F(ABaseThatSaysOnceThatItStops, AnotherSourceThanTwistIsNotHeld) {
  bus_.add<OdometryNode>(ConfigNode::parse("{auto_wait: 0}"));
  bus_.deliver("ENCODERS", encoders(0));
  const Utime start = simulation_.start();
  for (Utime t = 100'000; t < 1'000'000; t += 100'000) look(start + t);
  EXPECT_EQ(bus_.count("ODOMETRY"), 1U);
}

TEST_F(OdometryNodeTest, NoiseIsAddedWhenAskedFor) {
  bus_.add<OdometryNode>();
  bus_.add<OdometryNode>(ConfigNode::parse("{noise: {mode: white, sigma: 0.05}}"));
  for (Utime t = 0; t <= 2'000'000; t += 20'000) bus_.deliver("ENCODERS", encoders(t));
  double squares = 0;
  const auto odometry = bus_.on<odometry_t>("ODOMETRY");
  for (std::size_t i = 0; i < odometry.size(); i += 2)
    squares += std::pow(odometry[i].T_odom_robot.trans[0] - odometry[i + 1].T_odom_robot.trans[0], 2);
  EXPECT_GT(squares, 0);
}

}  // namespace
}  // namespace lcmslam

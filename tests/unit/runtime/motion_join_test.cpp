#include <lcmslam/runtime/motion_join.hpp>

#include <gmock/gmock.h>

#include <vector>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class Join : public ::testing::Test {
 protected:
  static MotionSample at(double seconds, double x = 0) {
    MotionSample sample;
    sample.utime = us(seconds);
    sample.T_odom_robot.translation().x() = x;
    return sample;
  }
  static Utime us(double seconds) { return static_cast<Utime>(std::llround(1e6 * seconds)); }
  void measure(double seconds, int name) { join_.add(us(seconds), name); }

  std::vector<int> released_;
  MotionJoin<int> join_{0.1, 3, [this](int& name) { released_.push_back(name); }};
};

TEST_F(Join, MeasurementWaitsUntilOdometryCoversIt) {
  join_.add(at(10.00));
  measure(10.03, 1);
  EXPECT_THAT(released_, IsEmpty());
  join_.add(at(10.02));
  EXPECT_THAT(released_, IsEmpty());
  join_.add(at(10.04));
  EXPECT_THAT(released_, ElementsAre(1));
  EXPECT_EQ(join_.without_odometry(), 0);
  measure(10.04, 2);  // covered already
  EXPECT_THAT(released_, ElementsAre(1, 2));
}

TEST_F(Join, VisualOdometryGoesOnForAMoment) {
  std::vector<int> released;
  MotionJoin<int> join(
      0.1, 3, [&](int& name) { released.push_back(name); }, 0.01);
  const auto add = [&](double seconds, double x, bool visual) {
    MotionSample sample = at(seconds, x);
    sample.visual = visual;
    join.add(sample);
  };
  add(10.00, 0, true);
  add(10.03, 0.3, true);
  join.add(us(10.035), 1);
  EXPECT_THAT(released, ElementsAre(1));
  EXPECT_EQ(join.without_odometry(), 0);
  const auto motion = join.between(us(10.03), us(10.035));
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->T_from_to.translation().x(), 0.05, 1e-9);
  join.add(us(10.045), 2);  // too far
  EXPECT_THAT(released, ElementsAre(1));
  add(10.06, 0.6, false);  // wheels come often enough
  EXPECT_THAT(released, ElementsAre(1, 2));
  join.add(us(10.065), 3);
  EXPECT_THAT(released, ElementsAre(1, 2));
  EXPECT_FALSE(join.between(us(10.06), us(10.065)));
}

TEST_F(Join, MeasurementsGoOnInTheirOrder) {
  for (int i = 0; i < 3; ++i) measure(10 + 0.01 * i, i);
  join_.add(at(10.5));
  EXPECT_THAT(released_, ElementsAre(0, 1, 2));
}

TEST_F(Join, GoesOnWithoutOdometryWhenMessageTimeHasMovedOn) {
  measure(10.0, 1);
  measure(10.1, 2);
  EXPECT_THAT(released_, IsEmpty());
  measure(10.11, 3);
  EXPECT_THAT(released_, ElementsAre(1));
  EXPECT_EQ(join_.without_odometry(), 1);
}

TEST_F(Join, TheOldestIsDroppedWhenTooManyWait) {
  for (int i = 0; i < 5; ++i) measure(10 + 0.001 * i, i);
  join_.flush();
  EXPECT_THAT(released_, ElementsAre(2, 3, 4));
  EXPECT_EQ(join_.dropped(), 2);
  EXPECT_EQ(join_.without_odometry(), 3);
}

TEST_F(Join, FlushLetsEverythingGoOn) {
  join_.flush();
  EXPECT_THAT(released_, IsEmpty());
  measure(10, 1);
  join_.flush();
  EXPECT_THAT(released_, ElementsAre(1));
}

TEST_F(Join, NewSessionKnowsNothingOfTheOldOne) {
  join_.add(at(100));
  join_.add(at(101));
  measure(101.05, 1);
  join_.begin_session();
  EXPECT_THAT(released_, ElementsAre(1)) << "what waited goes on as it is";
  EXPECT_TRUE(join_.motion().empty());
  measure(10.0, 2);
  join_.add(at(9.99));
  EXPECT_THAT(released_, ElementsAre(1)) << "time stands at 10 again: it waits";
  join_.add(at(10.01));
  EXPECT_THAT(released_, ElementsAre(1, 2));
  EXPECT_TRUE(join_.motion().covers(us(10.0)));
  EXPECT_FALSE(join_.motion().covers(us(100.5)));
}

TEST_F(Join, MotionIsKnownAfterAMinuteWithoutMeasurements) {
  for (int i = 0; i <= 60 * 50; ++i) join_.add(at(10 + 0.02 * i, 0.01 * i));
  const auto motion = join_.between(us(10), us(70));
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->T_from_to.translation().x(), 30, 1e-9);
}

TEST_F(Join, RepeatedOrLateOdometryLosesNothing) {
  join_.add(at(10.00, 1));
  join_.add(at(10.02, 2));
  measure(10.03, 1);
  join_.add(at(10.02, 2));
  join_.add(at(10.01, 1.5));
  EXPECT_THAT(released_, IsEmpty());
  join_.add(at(10.04, 3));
  EXPECT_THAT(released_, ElementsAre(1));
  const auto motion = join_.motion().between(us(10.00), us(10.04));
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->T_from_to.translation().x(), 2, 1e-12);
}

TEST_F(Join, OdometryOfAnotherSenderDoesNotCompareWithTheFirsts) {
  join_.add(at(10.00, 50), 1);
  join_.add(at(10.02, 50), 1);
  join_.add(at(10.04, 0), 2);  // the process restarted: its path begins at its start
  join_.add(at(10.06, 0.1), 2);
  EXPECT_FALSE(join_.motion().between(us(10.01), us(10.05)));
  ASSERT_TRUE(join_.motion().between(us(10.04), us(10.06)));
}

TEST_F(Join, WaitsForSomethingElseToo) {
  bool there = false;
  join_.need([&](int) { return there; }, 0.2);
  join_.add(at(10.05));
  measure(10.00, 1);
  EXPECT_THAT(released_, IsEmpty());
  join_.add(at(10.15));
  join_.look();
  EXPECT_THAT(released_, IsEmpty());
  there = true;
  join_.look();
  EXPECT_THAT(released_, ElementsAre(1));
  EXPECT_EQ(join_.without_other(), 0);
  there = false;
  measure(10.10, 2);
  join_.add(at(10.30));
  EXPECT_THAT(released_, ElementsAre(1));
  join_.add(at(10.31));  // 0.2 s of message time have gone
  EXPECT_THAT(released_, ElementsAre(1, 2));
  EXPECT_EQ(join_.without_other(), 1);
  EXPECT_EQ(join_.without_odometry(), 0);
}

}  // namespace
}  // namespace lcmslam

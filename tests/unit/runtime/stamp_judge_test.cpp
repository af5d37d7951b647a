#include <lcmslam/runtime/stamp_judge.hpp>

#include <gmock/gmock.h>

#include <limits>
#include <vector>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Odometry at 50 Hz and features at 10 Hz of one graph, at message times that the test chooses.
class Stamps : public ::testing::Test {
 protected:
  static constexpr Utime start = 1'000'000'000;
  static constexpr std::int64_t surf = 7, wheels = 8, stranger = 99;

  static Utime at(double seconds) { return start + static_cast<Utime>(std::llround(1e6 * seconds)); }

  StampVerdict features(double seconds, std::int64_t sender = surf) {
    return judge_.judge("FEATURES", sender, at(seconds));
  }
  StampVerdict odometry(double seconds, std::int64_t sender = wheels) {
    return judge_.judge("ODOMETRY", sender, at(seconds));
  }
  /// Both channels from one time to another, features each tenth of a second; how many were not taken.
  int drive(double from, double to, std::int64_t features_of = surf, std::int64_t odometry_of = wheels) {
    int left_out = 0;
    int i = 0;
    for (const double t : times(from, to, 0.02)) {
      left_out += !is_taken(odometry(t, odometry_of));
      if (i++ % 5 == 0) left_out += !is_taken(features(t, features_of));
    }
    return left_out;
  }
  /// From one time to before another.
  static std::vector<double> times(double from, double to, double step) {
    std::vector<double> all;
    for (int i = 0; from + step * i < to - 1e-9; ++i) all.push_back(from + step * i);
    return all;
  }
  static bool is_taken(StampVerdict verdict) {
    return verdict == StampVerdict::take || verdict == StampVerdict::new_session;
  }

  StampJudge judge_;
};

TEST_F(Stamps, ThatGoOnAreTaken) {
  EXPECT_EQ(drive(0, 10), 0);
  EXPECT_EQ(judge_.now(), at(9.98));
  EXPECT_THAT(judge_.trouble(), IsEmpty());
}

TEST_F(Stamps, OfThePastAreLate) {
  drive(0, 5);
  EXPECT_EQ(features(4.9), StampVerdict::late);
  EXPECT_EQ(features(4.3), StampVerdict::late);
  EXPECT_EQ(drive(5, 6), 0);
  EXPECT_EQ(judge_.refused(), 0);
}

TEST_F(Stamps, OneThatIsWrongChangesNothing) {
  drive(0, 5);
  constexpr Utime largest = std::numeric_limits<Utime>::max(), smallest = std::numeric_limits<Utime>::min();
  for (const Utime wrong : {at(15), at(-5), at(3e6), Utime{0}, Utime{-1}, largest, smallest}) {
    EXPECT_EQ(judge_.judge("FEATURES", surf, wrong), StampVerdict::refused) << wrong;
    EXPECT_EQ(judge_.judge("ODOMETRY", wheels, wrong), StampVerdict::refused) << wrong;
  }
  EXPECT_EQ(judge_.refused(), 14);
  EXPECT_EQ(drive(5, 10), 0);
  EXPECT_EQ(judge_.sessions(), 1);
  EXPECT_THAT(judge_.trouble(), HasSubstr("FEATURES: 7 stamps refused"));
}

TEST_F(Stamps, WrongOnesBetweenRightOnesAreNeverBelieved) {
  drive(0, 2);
  for (const double t : times(2, 20, 0.02)) {
    EXPECT_EQ(odometry(t), StampVerdict::take);
    EXPECT_EQ(features(t + 10), StampVerdict::refused) << t;  // all of them, and odometry contradicts
    EXPECT_EQ(odometry(t - 10), StampVerdict::refused) << t;
  }
  EXPECT_EQ(judge_.sessions(), 1);
}

TEST_F(Stamps, AFewThatRiseByChanceAreNoRun) {
  drive(0, 5);
  for (const double wrong : {20.0, 25.0, 31.0, -30.0, -24.0, -20.0})
    EXPECT_EQ(features(wrong), StampVerdict::refused) << wrong;
  EXPECT_EQ(drive(5, 6), 0);
  EXPECT_EQ(judge_.sessions(), 1);
}

TEST_F(Stamps, FirstOfAChannelMustFitTheOthers) {
  for (const double t : times(0, 2, 0.02)) odometry(t);
  EXPECT_EQ(features(12), StampVerdict::refused);
  EXPECT_EQ(features(1.9), StampVerdict::take);
}

TEST_F(Stamps, GapOfOneChannelIsVouchedForByTheOther) {
  drive(0, 2);
  for (const double t : times(2, 60, 0.02)) ASSERT_EQ(odometry(t), StampVerdict::take);
  EXPECT_EQ(features(60), StampVerdict::take);
  EXPECT_EQ(drive(60.02, 62), 0);
}

TEST_F(Stamps, GapOfAllCostsAFewMessagesAndNoSession) {
  drive(0, 5);
  const int left_out = drive(15, 20);
  EXPECT_GT(left_out, 0);
  EXPECT_LT(left_out, 40);  // half a second of both
  EXPECT_EQ(judge_.sessions(), 1);
  EXPECT_EQ(drive(20, 25), 0);
}

TEST_F(Stamps, SlowChannelAloneIsBelieved) {
  std::vector<StampVerdict> verdicts;
  for (const double t : times(0, 40, 2)) verdicts.push_back(judge_.judge("CAMERA", 1, at(t)));
  EXPECT_LE(std::count(verdicts.begin(), verdicts.end(), StampVerdict::refused), 3);
  EXPECT_EQ(verdicts.back(), StampVerdict::take);
}

TEST_F(Stamps, LogThatLoopsBeginsOneSession) {
  drive(0, 26);
  EXPECT_LT(drive(0, 5), 40);
  EXPECT_EQ(judge_.sessions(), 2);
  EXPECT_EQ(drive(5, 26), 0);
  EXPECT_EQ(judge_.sessions(), 2);
  EXPECT_THAT(judge_.trouble(), IsEmpty());
}

TEST_F(Stamps, JumpBackOfOneChannelAloneIsRefused) {
  drive(0, 26);
  for (const double t : times(0, 10, 0.1)) {
    EXPECT_EQ(features(t), StampVerdict::refused);
    for (const double s : times(t, t + 0.1, 0.02)) EXPECT_EQ(odometry(26 + s), StampVerdict::take);
  }
  EXPECT_EQ(judge_.sessions(), 1);
}

TEST_F(Stamps, SecondPublisherIsLeftOutWhileTheFirstIsAlive) {
  drive(0, 5);
  for (const double t : times(5, 15, 0.1)) {
    EXPECT_EQ(features(t), StampVerdict::take);
    EXPECT_EQ(features(t + 0.03, stranger), StampVerdict::foreign);
    EXPECT_EQ(features(t + 100, stranger), StampVerdict::foreign);
    EXPECT_EQ(odometry(t), StampVerdict::take);
  }
  EXPECT_EQ(judge_.foreign(), 200);
  EXPECT_THAT(judge_.trouble(),
              HasSubstr("FEATURES: 200 messages of another sender (99) left out, 7 is kept"));
  EXPECT_EQ(judge_.sessions(), 1);
}

TEST_F(Stamps, ProcessThatRestartedIsTakenOver) {
  drive(0, 5);
  for (const double t : times(5, 8, 0.02)) odometry(t);  // surf is away
  EXPECT_EQ(drive(8, 9, surf + 1), 0);
  EXPECT_EQ(judge_.sessions(), 1);
}

TEST_F(Stamps, PublisherThatIsReplacedAtOnceIsTakenOverSoon) {
  drive(0, 5);
  EXPECT_LT(drive(5, 8, surf, wheels + 1), 60);  // of 150: odometry counts until the run is believed
  EXPECT_EQ(drive(8, 9, surf, wheels + 1), 0);
  EXPECT_GT(judge_.foreign(), 0);
  EXPECT_THAT(judge_.trouble(), IsEmpty()) << "whom it doubted is the one that it keeps";
  odometry(9, stranger);
  EXPECT_THAT(judge_.trouble(), HasSubstr("ODOMETRY: 1 messages of another sender (99) left out, 9 is kept"));
}

// A killed process is back after a quarter of a second; his first message is doubted.
TEST_F(Stamps, SuccessorIsBelievedSoonWhereTheOthersTellThatItsPredecessorIsSilent) {
  drive(0, 5);
  for (const double t : times(5, 5.25, 0.02)) odometry(t);
  EXPECT_EQ(drive(5.26, 7, surf + 1), 1);
  EXPECT_EQ(judge_.sessions(), 1);
}

// A killed camera takes all clocks with it: what comes after its silence is believed in a third of a second.
TEST_F(Stamps, SuccessorAfterASilenceOfAllIsBelievedSooner) {
  drive(0, 5);
  int left_out = 0;
  for (const double t : times(5.5, 7, 0.1)) left_out += !is_taken(features(t, surf + 1));
  EXPECT_EQ(left_out, 3);
  EXPECT_EQ(judge_.sessions(), 1);
  EXPECT_EQ(judge_.kept_sender("FEATURES"), surf + 1);
}

TEST_F(Stamps, SuccessorAtOnceWaitsLonger) {
  drive(0, 5);
  int left_out = 0;
  for (const double t : times(5, 7, 0.1)) left_out += !is_taken(features(t, surf + 1));
  EXPECT_EQ(left_out, 5) << "nothing says that his predecessor fell silent before him";
}

TEST_F(Stamps, SuccessorOfASlowChannelWaitsForAsManyOfItsPeriods) {
  int left_out = 0;
  for (const double t : times(0, 20, 0.02)) odometry(t);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(judge_.judge("CAMERA", 1, at(20 + 0.5 * i)), StampVerdict::take);
  for (int i = 0; i < 20; ++i) {
    for (const double t : times(30 + 0.5 * i, 30.5 + 0.5 * i, 0.02)) odometry(t);
    left_out += !is_taken(judge_.judge("CAMERA", 2, at(30.5 + 0.5 * i)));
  }
  EXPECT_GE(left_out, 1);
  EXPECT_LE(left_out, 3);
}

// However seldom it speaks, however often the stranger does, and whatever he stamps.
TEST_F(Stamps, StrangerBesideALivingPublisherIsNeverBelieved) {
  for (const double rate : {1.0, 2.0, 10.0, 30.0})
    for (const double stranger_rate : {1.0, 10.0, 50.0})
      for (const double ahead : {-0.5, -0.05, 0.0, 0.4, 1.5}) {
        SCOPED_TRACE(::testing::Message()
                     << rate << " Hz, stranger " << stranger_rate << " Hz, ahead " << ahead);
        judge_ = StampJudge();
        double next = 0, next_stranger = 4;
        for (const double t : times(0, 12, 0.02)) {
          ASSERT_EQ(odometry(t), StampVerdict::take);
          if (t >= next) {
            ASSERT_EQ(features(t), StampVerdict::take);
            next += 1 / rate;
          }
          if (t >= next_stranger) {
            ASSERT_FALSE(is_taken(features(t + ahead, stranger)));
            next_stranger += 1 / stranger_rate;
          }
        }
      }
}

// A busy machine: what was measured long ago, and pauses that are no deaths.
TEST_F(Stamps, StrangerIsNotBelievedForThatALivingPublisherIsLate) {
  drive(0, 4);
  for (const double t : times(4, 12, 0.02)) {
    ASSERT_EQ(odometry(t), StampVerdict::take);
    if (t < 4.5) continue;
    const bool living_speaks = std::lround(50 * t) % 5 == 0;
    if (living_speaks) {
      ASSERT_EQ(features(t - 0.45), StampVerdict::take) << t;
    }
    ASSERT_FALSE(is_taken(features(t, stranger))) << t;
  }
}

TEST_F(Stamps, StrangerIsNotBelievedForThatTheOthersCameLate) {
  drive(0, 4);
  for (const double t : times(4, 12, 0.5)) {  // odometry comes in bursts
    for (const double f : times(t, t + 0.5, 0.1)) {
      ASSERT_EQ(features(f), StampVerdict::take);
      ASSERT_FALSE(is_taken(features(f + 0.01, stranger)));
      ASSERT_FALSE(is_taken(features(f + 0.03, stranger)));
    }
    for (const double o : times(t, t + 0.5, 0.02)) ASSERT_EQ(odometry(o), StampVerdict::take);
    for (const double late : {0.42, 0.44, 0.46}) ASSERT_FALSE(is_taken(features(t + late, stranger)));
  }
}

TEST_F(Stamps, TwoStrangersDoNotVouchForEachOther) {
  for (const double t : times(0, 10, 1)) EXPECT_EQ(features(t), StampVerdict::take);  // at 1 Hz
  for (const double t : times(109.05, 109.95, 0.02)) {
    EXPECT_EQ(features(t, 50), StampVerdict::foreign);
    EXPECT_EQ(features(t, 51), StampVerdict::foreign);
  }
  EXPECT_EQ(features(10), StampVerdict::take);
}

// What erased maps: whoever forges stamps between those of living publishers never begins a session, and
// takes no more than what he sends.
TEST_F(Stamps, NoRandomStampsBetweenLivingPublishersBeginASession) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    judge_ = StampJudge();
    Random random(seed);
    drive(0, 2);
    int left_out = 0;
    for (const double t : times(2, 12, 0.1)) {
      for (int n = static_cast<int>(5 * random.uniform()); n > 0; --n) {
        const double wrong = t + (random.uniform() < 0.5 ? 1e3 : 15) * (random.uniform() - 0.5);
        const std::int64_t sender = random.uniform() < 0.5 ? surf : stranger;
        if (std::abs(wrong - t) < 2.2) continue;  // late, or ahead by what latency may explain
        EXPECT_FALSE(is_taken(random.uniform() < 0.5 ? features(wrong, sender) : odometry(wrong, sender)));
      }
      left_out += drive(t, t + 0.1);
    }
    EXPECT_EQ(left_out, 0);
    EXPECT_EQ(judge_.sessions(), 1);
  }
}

}  // namespace
}  // namespace lcmslam

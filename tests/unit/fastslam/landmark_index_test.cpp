#include <lcmslam/fastslam/landmarks/landmark_index.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

class LandmarkIndexTest : public testing::Test {
 protected:
  LandmarkIndexTest() {
    settings_.minimum_observations = 3;
    settings_.tentative_steps = 5;
  }
  Feature feature(std::int32_t known_id = -1) {
    Feature f;
    f.landmark_id = known_id;
    f.laplacian = 1;
    for (auto& byte : f.descriptor) byte = static_cast<std::uint8_t>(random_.below(256));
    return f;
  }
  int forgotten_after(int steps) {
    int forgotten = 0;
    for (int i = 0; i < steps; ++i) forgotten += index_.age(settings_);
    return forgotten;
  }

  Random random_{3};
  FastSlamSettings settings_;
  LandmarkIndex index_;
};

TEST_F(LandmarkIndexTest, WhatWasSeenOnceIsForgottenAndItsSlotIsUsedAgain) {
  const int slot = index_.add(feature(), settings_);
  EXPECT_EQ(forgotten_after(5), 0);
  EXPECT_TRUE(index_.alive(slot));
  EXPECT_EQ(forgotten_after(1), 1);
  EXPECT_FALSE(index_.alive(slot));
  EXPECT_EQ(index_.size(), 0);
  EXPECT_EQ(index_.search().size(), 0U);
  EXPECT_EQ(index_.add(feature(), settings_), slot);
}

TEST_F(LandmarkIndexTest, BeingSeenAgainGivesTimeAndBeingWellKnownForEver) {
  const Feature seen = feature();
  const int slot = index_.add(seen, settings_);
  EXPECT_EQ(forgotten_after(4), 0);
  index_.observe(slot, seen, settings_);
  EXPECT_EQ(forgotten_after(5), 0);
  EXPECT_EQ(index_.unseen_steps(slot), 5);
  index_.observe(slot, seen, settings_);
  EXPECT_EQ(index_.record(slot).observations, 3);
  EXPECT_EQ(forgotten_after(100), 0);
  EXPECT_TRUE(index_.alive(slot));
}

TEST_F(LandmarkIndexTest, KnownIdentitiesAreFoundAndStay) {
  const int slot = index_.add(feature(17), settings_);
  EXPECT_EQ(index_.find(17), slot);
  EXPECT_EQ(index_.find(18), -1);
  EXPECT_EQ(index_.find(-1), -1);
  EXPECT_EQ(forgotten_after(100), 0);
  EXPECT_EQ(index_.search().size(), 0U) << "never sought by its descriptor";
}

TEST_F(LandmarkIndexTest, MissesKillWhatHitsKeepAlive) {
  settings_.odds_new = 0;
  settings_.odds_hit = 1;
  settings_.odds_miss = -1;
  settings_.odds_maximum = 2;
  settings_.odds_remove = -1;
  const Feature seen = feature();
  const int slot = index_.add(seen, settings_);
  for (int i = 0; i < 10; ++i) index_.observe(slot, seen, settings_);
  EXPECT_FALSE(index_.miss(slot, settings_));
  EXPECT_FALSE(index_.miss(slot, settings_));
  EXPECT_TRUE(index_.miss(slot, settings_)) << "ten hits count no more than the maximum";
  EXPECT_FALSE(index_.alive(slot));
}

TEST_F(LandmarkIndexTest, TellsOnceWhichSlotsWereTouched) {
  const Feature seen = feature();
  const int a = index_.add(seen, settings_), b = index_.add(feature(), settings_);
  EXPECT_EQ(index_.take_touched(), (std::vector<int>{a, b}));
  EXPECT_TRUE(index_.take_touched().empty());
  index_.observe(a, seen, settings_);
  index_.observe(a, seen, settings_);
  EXPECT_EQ(index_.take_touched(), std::vector<int>{a});
}

}  // namespace
}  // namespace lcmslam

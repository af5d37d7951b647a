#include <lcmslam/map_store/landmark_map.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

using testing::ElementsAre;

std::vector<std::int64_t> ids(const LandmarkMap& map) {
  std::vector<std::int64_t> result;
  for (const Landmark& landmark : map.landmarks()) result.push_back(landmark.id);
  return result;
}

TEST(LandmarkMap, ChangesUpsertAndRemove) {
  LandmarkMap map;
  EXPECT_TRUE(map.apply({1, 0, {landmark(7), landmark(3)}, {}}));
  EXPECT_TRUE(map.apply({2, 1, {landmark(3, 5), landmark(1)}, {7, 99}}));
  EXPECT_THAT(ids(map), ElementsAre(1, 3));
  EXPECT_EQ(map.revision(), 2);
  ASSERT_NE(map.find(3), nullptr);
  EXPECT_DOUBLE_EQ(map.find(3)->mean.x(), 5);
  EXPECT_EQ(map.find(7), nullptr);
}

TEST(LandmarkMap, GivesTheNextOnesById) {
  LandmarkMap map;
  map.apply({1, 0, {landmark(7), landmark(3), landmark(1), landmark(9)}, {}});
  const auto next = map.after(1, 2);
  ASSERT_EQ(next.size(), 2U);
  EXPECT_EQ(next[0].id, 3);
  EXPECT_EQ(next[1].id, 7);
  EXPECT_EQ(map.after(-1, 10).size(), 4U);
  EXPECT_TRUE(map.after(9, 10).empty());
}

TEST(LandmarkMap, ARepeatedChangeIsLeftOut) {
  LandmarkMap map;
  map.apply({1, 0, {landmark(1)}, {}});
  map.apply({2, 1, {landmark(2)}, {}});
  EXPECT_TRUE(map.apply({2, 1, {landmark(2, 9)}, {}}));
  EXPECT_DOUBLE_EQ(map.find(2)->mean.x(), 0);
}

TEST(LandmarkMap, AMissedChangeIsNoticedUntilTheWholeMapCame) {
  LandmarkMap map;
  map.apply({1, 0, {landmark(1)}, {}});
  EXPECT_FALSE(map.apply({3, 2, {landmark(3)}, {}}));
  EXPECT_TRUE(map.incomplete());
  EXPECT_THAT(ids(map), ElementsAre(1, 3)) << "what is known is shown meanwhile";
  EXPECT_FALSE(map.apply({4, 3, {landmark(4)}, {}})) << "landmark 2 is still missing";
  EXPECT_TRUE(map.add_tile({4, 0, 1, {landmark(1), landmark(2), landmark(3), landmark(4)}}));
  EXPECT_FALSE(map.incomplete());
  EXPECT_THAT(ids(map), ElementsAre(1, 2, 3, 4));
  EXPECT_TRUE(map.apply({5, 4, {}, {1}}));
  EXPECT_THAT(ids(map), ElementsAre(2, 3, 4));
}

TEST(LandmarkMap, ALateChangeDoesNotOverwriteNewerLandmarks) {
  LandmarkMap map;
  map.apply({1, 0, {landmark(1, 1)}, {}});
  map.apply({3, 2, {landmark(1, 3)}, {}});
  map.apply({2, 1, {landmark(1, 2)}, {}});
  EXPECT_DOUBLE_EQ(map.find(1)->mean.x(), 3);
  EXPECT_TRUE(map.incomplete());
}

TEST(LandmarkMap, TilesComeInAnyOrderAndRepeatedly) {
  std::vector<int> order = {0, 1, 2, 3};
  do {
    LandmarkMap map;
    map.apply({9, 0, {landmark(100)}, {}});
    map.apply({11, 10, {}, {}});
    for (std::size_t i = 0; i < order.size(); ++i) {
      const LandmarkTile tile{11, order[i], 4, {landmark(order[i])}};
      EXPECT_EQ(map.add_tile(tile), i == 3);
      if (i < 3) {
        EXPECT_FALSE(map.add_tile(tile)) << "a repeated tile does not count twice";
        EXPECT_TRUE(map.incomplete());
        EXPECT_NE(map.find(100), nullptr) << "the old map stays until the new one is whole";
      }
    }
    EXPECT_THAT(ids(map), ElementsAre(0, 1, 2, 3));
    EXPECT_FALSE(map.incomplete());
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(LandmarkMap, TilesOfDifferentRevisionsDoNotMix) {
  LandmarkMap map;
  EXPECT_FALSE(map.add_tile({5, 0, 2, {landmark(1)}}));
  EXPECT_FALSE(map.add_tile({6, 1, 2, {landmark(2)}}));
  EXPECT_TRUE(map.add_tile({6, 0, 2, {landmark(3)}}));
  EXPECT_THAT(ids(map), ElementsAre(2, 3));
  EXPECT_EQ(map.revision(), 6);
  EXPECT_FALSE(map.add_tile({6, 0, 1, {}})) << "a resend for somebody else";
  EXPECT_EQ(map.size(), 2u);
}

TEST(LandmarkMap, ChangesThatComeBetweenTilesFollowTheReplacement) {
  LandmarkMap map;
  map.apply({1, 0, {landmark(1)}, {}});
  map.apply({5, 4, {landmark(5)}, {}});  // 2..4 were lost
  map.add_tile({5, 0, 2, {landmark(2)}});
  map.apply({6, 5, {landmark(6)}, {2}});
  map.apply({7, 6, {landmark(7)}, {}});
  EXPECT_TRUE(map.add_tile({5, 1, 2, {landmark(4), landmark(5)}}));
  EXPECT_THAT(ids(map), ElementsAre(4, 5, 6, 7));
  EXPECT_EQ(map.revision(), 7);
  EXPECT_FALSE(map.incomplete());

  map.apply({9, 8, {}, {}});  // 8 was lost
  map.apply({11, 10, {}, {}});
  map.add_tile({9, 0, 1, {landmark(1)}});
  EXPECT_TRUE(map.incomplete()) << "10 was lost after the revision that was sent";
}

TEST(LandmarkMap, AMapperThatBeginsAnewIsFollowed) {
  LandmarkMap map;
  map.apply({500, 0, {landmark(1), landmark(2)}, {}});
  EXPECT_TRUE(map.apply({1, 0, {landmark(9)}, {}}));
  EXPECT_THAT(ids(map), ElementsAre(9));

  LandmarkMap missed;  // its first change was lost
  missed.apply({500, 0, {landmark(1)}, {}});
  missed.apply({501, 500, {landmark(2)}, {}});
  EXPECT_FALSE(missed.apply({2, 1, {landmark(9)}, {}}));
  EXPECT_TRUE(missed.add_tile({2, 0, 1, {landmark(8), landmark(9)}}));
  EXPECT_THAT(ids(missed), ElementsAre(8, 9));
  EXPECT_FALSE(missed.incomplete());
}

TEST(LandmarkMap, RandomLossAndReorderingEndInTheSamePicture) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    LandmarkMap sender, receiver;
    std::vector<LandmarkChange> sent;
    for (std::int64_t revision = 1; revision <= 40; ++revision) {
      LandmarkChange change{revision, revision - 1, {}, {}};
      for (int i = 0; i < 3; ++i)
        change.upserted.push_back(landmark(static_cast<std::int64_t>(random.below(20)), random.uniform()));
      change.removed = {static_cast<std::int64_t>(random.below(20))};
      sender.apply(change);
      sent.push_back(change);
      if (random.uniform() < 0.8) receiver.apply(change);
      if (random.uniform() < 0.1) receiver.apply(sent[random.below(sent.size())]);
    }
    receiver.add_tile({sender.revision(), 0, 1, sender.landmarks()});
    ASSERT_FALSE(receiver.incomplete()) << "seed " << seed;
    ASSERT_EQ(ids(receiver), ids(sender)) << "seed " << seed;
    for (const Landmark& expected : sender.landmarks())
      ASSERT_EQ(receiver.find(expected.id)->mean, expected.mean) << "seed " << seed;
  }
}

TEST(LandmarkMap, MessagesMakeNoMoreThanTheLimit) {
  LandmarkMap map(3);
  EXPECT_TRUE(map.apply({1, 0, {landmark(1, 0), landmark(2, 0), landmark(3, 0)}, {}}));
  EXPECT_THROW(map.apply({2, 1, {landmark(4, 0)}, {}}), std::invalid_argument);
  EXPECT_EQ(map.revision(), 1);
  EXPECT_TRUE(map.apply({2, 1, {landmark(3, 5)}, {}})) << "one that is known";
  EXPECT_TRUE(map.apply({3, 0, {landmark(7, 0), landmark(8, 0), landmark(9, 0)}, {}})) << "another whole map";
  EXPECT_FALSE(map.add_tile({4, 0, 2, {landmark(1, 0), landmark(2, 0)}}));
  EXPECT_THROW(map.add_tile({4, 1, 2, {landmark(3, 0), landmark(4, 0)}}), std::invalid_argument);
  EXPECT_EQ(map.size(), 3U);
}

TEST(LandmarkMap, ImpossibleTilesAreRefused) {
  LandmarkMap map;
  for (const auto& [tile, tiles] : {std::pair{-1, 2}, {2, 2}, {0, 0}, {0, -5}, {0, 1 << 30}})
    EXPECT_THROW(map.add_tile({1, tile, tiles, {}}), std::invalid_argument) << tile << " of " << tiles;
  EXPECT_TRUE(map.add_tile({1, 0, 1, {}}));
  EXPECT_EQ(map.size(), 0u);
}

}  // namespace
}  // namespace lcmslam

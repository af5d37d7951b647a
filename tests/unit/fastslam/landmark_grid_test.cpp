#include <lcmslam/fastslam/landmarks/landmark_grid.hpp>

#include <gtest/gtest.h>

#include <map>
#include <set>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

// Landmarks come, move and die in several copies of a map, of which now one, now another is followed.
TEST(LandmarkGrid, HoldsWhatTheFollowedMapHolds) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    FastSlamSettings settings;
    LandmarkIndex index;
    std::vector<ParticleMap> maps(3);
    LandmarkGrid grid;
    const auto anywhere = [&] {
      return Eigen::Vector3d(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(0, 3));
    };
    for (int round = 0; round < 60; ++round) {
      for (int i = 0; i < 20; ++i) {
        const int slot = index.add(Feature(), settings);
        for (ParticleMap& map : maps) map.edit(static_cast<std::size_t>(slot)).mean = anywhere();
      }
      for (int i = 0; i < 15; ++i) {
        const int slot = static_cast<int>(random.below(static_cast<std::uint64_t>(index.slots())));
        if (!index.alive(slot)) continue;
        if (i % 3 == 0) {
          while (!index.miss(slot, settings)) continue;
        } else {
          maps[random.below(3)].edit(static_cast<std::size_t>(slot)).mean = anywhere();
        }
      }
      if (round % 7 == 3) maps[0] = maps[2];  // resampling
      const ParticleMap& map = maps[random.below(3)];
      grid.follow(map, index);

      const Eigen::Vector3d centre = anywhere();
      std::map<int, Eigen::Vector3d> found;
      const auto near = [&](const Eigen::Vector3d& middle, double radius) {
        return (middle - centre).norm() <= 4 + radius;
      };
      grid.for_each(near, [&](const LandmarkGrid::Entry& entry) {
        if (!index.alive(entry.slot)) return;
        EXPECT_TRUE(found.emplace(entry.slot, entry.mean).second) << "twice";
        EXPECT_LT((entry.mean - centre).norm(), 4 + 2 * std::sqrt(3.) + 1e-9) << "far away";
      });
      for (int slot = 0; slot < index.slots(); ++slot) {
        if (!index.alive(slot)) continue;
        const Eigen::Vector3d mean = map.find(static_cast<std::size_t>(slot))->mean;
        if ((mean - centre).norm() > 4) continue;
        ASSERT_EQ(found.count(slot), 1u) << slot;
        EXPECT_EQ(found[slot], mean);
      }
    }
  }
}

TEST(LandmarkGrid, KnownIdentitiesAreLeftOut) {
  LandmarkIndex index;
  ParticleMap map;
  Feature feature;
  feature.landmark_id = 7;
  map.edit(static_cast<std::size_t>(index.add(feature, {}))).mean.setZero();
  LandmarkGrid grid;
  grid.follow(map, index);
  grid.for_each([](const auto&, double) { return true; }, [](const auto&) { FAIL(); });
}

TEST(LandmarkIndex, ForgetsWhatIsTentativeAndUnseen) {
  FastSlamSettings settings;
  settings.tentative_steps = 10;
  settings.minimum_observations = 3;
  LandmarkIndex index;
  const int once = index.add(Feature(), settings), again = index.add(Feature(), settings),
            established = index.add(Feature(), settings);
  for (int i = 0; i < 2; ++i) index.observe(established, Feature(), settings);
  Feature beacon;
  beacon.landmark_id = 3;
  const int known = index.add(beacon, settings);
  int forgotten = 0;
  for (int step = 1; step <= 16; ++step) {
    if (step == 6) index.observe(again, Feature(), settings);
    forgotten += index.age(settings);
    EXPECT_EQ(index.alive(once), step <= 10) << step;
    EXPECT_EQ(index.alive(again), step <= 15) << step;
    EXPECT_EQ(forgotten, step <= 10 ? 0 : step <= 15 ? 1 : 2) << step;
  }
  EXPECT_TRUE(index.alive(established));
  EXPECT_TRUE(index.alive(known));
  EXPECT_EQ(index.unseen_steps(established), 16);
}

TEST(LandmarkIndex, TellsWhatWasTouched) {
  FastSlamSettings settings;
  LandmarkIndex index;
  for (int i = 0; i < 4; ++i) index.add(Feature(), settings);
  EXPECT_EQ(index.take_touched(), (std::vector<int>{0, 1, 2, 3}));
  index.observe(2, Feature(), settings);
  index.observe(2, Feature(), settings);
  while (!index.miss(1, settings)) continue;
  EXPECT_EQ(index.take_touched(), (std::vector<int>{1, 2}));
  EXPECT_TRUE(index.take_touched().empty());
}

}  // namespace
}  // namespace lcmslam

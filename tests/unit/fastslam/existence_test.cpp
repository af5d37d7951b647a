#include <lcmslam/fastslam/landmarks/existence.hpp>

#include <gtest/gtest.h>

#include "tests/unit/fastslam/association_scene.hpp"

namespace lcmslam {
namespace {

/// What is made of a frame of a known place, of which every second feature finds its landmark.
struct KnownPlace : AssociationScene {
  std::vector<FeaturePoint> usable = usable_features(frame, settings);
  std::vector<LandmarkMatch> matches;

  explicit KnownPlace(std::uint64_t seed) : AssociationScene(seed) {
    const std::vector<LandmarkMatch> all = match(usable);
    for (std::size_t i = 0; i < all.size(); i += 2) matches.push_back(all[i]);
    settings.maximum_observations = 2 * static_cast<int>(matches.size());
    settings.cell_capacity = 1;
  }

  /// `age`: s, of all landmarks.
  std::size_t births(double age) {
    frame.utime = 100'000'000;
    for (int slot = 0; slot < index.slots(); ++slot)
      index.record(slot).born = frame.utime - static_cast<Utime>(1e6 * age);
    const auto visible = visible_landmarks(map, index, T_world_robot, frame, settings);
    return choose_new_landmarks(frame, usable, visible, matches, index, T_world_robot, settings).size();
  }
};

TEST(NewLandmarks, AreFewWhereAFormerVisitLeftSome) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    KnownPlace place(seed);
    const std::size_t first_visit = place.births(10);
    EXPECT_GT(first_visit, 10U);
    EXPECT_LT(2 * place.births(30), first_visit);
    // A robot that recognises little needs what it can get.
    place.settings.maximum_observations += 2;
    EXPECT_EQ(place.births(30), first_visit);
  }
}

TEST(NewLandmarks, OneInACellIsEnoughInAKnownPlace) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    KnownPlace place(seed);
    const std::size_t first_visit = place.births(10), later = place.births(30);
    place.settings.cell_capacity = 3;
    EXPECT_GT(place.births(10), first_visit);
    EXPECT_EQ(place.births(30), later);
  }
}

TEST(NewLandmarks, LandmarksBehindWhatIsSeenTakeNoRoom) {
  KnownPlace place(2);
  const std::size_t first_visit = place.births(10);
  for (FeaturePoint& point : place.usable) point.range *= 0.5;
  EXPECT_EQ(place.births(30), first_visit);
}

TEST(Existence, TimePassesWhereLandmarksStay) {
  KnownPlace place(1);
  for (const bool remove : {true, false}) {
    place.settings.remove_landmarks = remove;
    const auto before = place.index.unseen_steps(0);
    for (int i = 0; i < 3; ++i)
      update_existence(place.index, place.map, place.frame, place.usable, {}, {}, {}, place.T_world_robot,
                       place.settings);
    EXPECT_EQ(place.index.unseen_steps(0), before + 3) << remove;
  }
}

}  // namespace
}  // namespace lcmslam

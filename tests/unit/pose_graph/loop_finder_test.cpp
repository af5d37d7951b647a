#include <lcmslam/pose_graph/loop_finder.hpp>

#include <gmock/gmock.h>

#include "tests/unit/dense_mapper/gallery.hpp"

namespace lcmslam {
namespace {

TEST(LoopFinder, NamesTheKeyframeThatLooksAlikeAndMeasuresIt) {
  Gallery gallery(9);
  LoopFinder finder({});
  for (int i = 0; i < 5; ++i) {
    auto view = std::make_shared<KeyframeView>(
        gallery.seen_from(Eigen::Isometry3d(Eigen::Translation3d(1.5 * i, 0, 0))));
    view->node = i;
    finder.add(view);
  }
  const Eigen::Isometry3d T = se3_exp(twist(4.6, 0.05, -0.05, 0, 0, 0)) * se3_exp(twist(0, 0, 0, 0, 0.05, 0));
  const KeyframeView view = gallery.seen_from(T);
  const auto candidates = finder.candidates(view.features, {});
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates.front(), 3);
  EXPECT_THAT(finder.candidates(view.features, {3}), testing::Not(testing::Contains(3)));
  const auto measured = finder.verify(*finder.view(3), view, std::nullopt);
  ASSERT_TRUE(measured);
  const UncertainTransform error{
      measured->T.inverse() * Eigen::Isometry3d(Eigen::Translation3d(-4.5, 0, 0)) * T, measured->covariance};
  EXPECT_LT(error.T.translation().norm(), 0.01);
  EXPECT_LT(rotation_angle(error.T), 0.005);
  EXPECT_LT(distance_from_identity(error), 4.7);  // no surer than it is
}

TEST(LoopFinder, RefusesAnotherPlace) {
  Gallery here(1), elsewhere(2);
  LoopFinder finder({});
  auto view = std::make_shared<KeyframeView>(here.seen_from(Eigen::Isometry3d::Identity()));
  finder.add(view);
  const KeyframeView other = elsewhere.seen_from(Eigen::Isometry3d::Identity());
  EXPECT_TRUE(finder.candidates(other.features, {}).empty());
  EXPECT_FALSE(finder.verify(*view, other, std::nullopt));
  EXPECT_FALSE(finder.verify(*view, {}, Eigen::Isometry3d::Identity()));
  // The same things in another order in space: descriptors agree, geometry does not.
  KeyframeView shuffled = here.seen_from(Eigen::Isometry3d::Identity());
  auto& features = shuffled.features.features;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const auto& from = view->features.features[(7 * i + 3) % features.size()];
    features[i].point = from.point;
  }
  EXPECT_FALSE(finder.verify(*view, shuffled, std::nullopt));
}

// Tiles of a wall: the nearest and the third nearest descriptor may be of one keyframe.
TEST(LoopFinder, AFeatureVotesForAKeyframeOnce) {
  LoopFinderSettings settings;
  settings.min_votes = 15;
  LoopFinder finder(settings);
  Random random(5);
  const auto feature = [](Descriptor descriptor, std::uint8_t away) {
    Feature f;
    descriptor[0] = away;
    f.descriptor = descriptor;
    return f;
  };
  auto tiles = std::make_shared<KeyframeView>(), other = std::make_shared<KeyframeView>();
  tiles->node = 0, other->node = 1;
  FeatureFrame seen;
  for (int i = 0; i < 10; ++i) {
    Descriptor descriptor;
    for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(256 * random.uniform());
    seen.features.push_back(feature(descriptor, 0));
    tiles->features.features.push_back(feature(descriptor, 1));
    other->features.features.push_back(feature(descriptor, 2));
    tiles->features.features.push_back(feature(descriptor, 3));
  }
  finder.add(tiles);
  finder.add(other);
  EXPECT_TRUE(finder.candidates(seen, {}).empty()) << "ten features are ten votes";
}

// Along a bare floor registration stays where it began: height and tilt are measured, and nothing else.
TEST(LoopFinder, ABareFloorMeasuresHeightAndTilt) {
  LoopFinder finder({});
  const auto view_of = [](const Cloud& cloud) {
    KeyframeView view;
    view.cloud = cloud;
    view.cloud.sigmas.assign(cloud.size(), 0.003f);
    return view;
  };
  Cloud floor;
  add_rectangle(floor, {1, -1.5, -1}, {2, 0, 0}, {0, 3, 0}, 0.03);
  const Eigen::Isometry3d guess = se3_exp(twist(0.02, 0.02, 0.01, 0, 0, 0.01));
  const auto sigmas = [&](const Cloud& cloud) {
    const auto measured = finder.verify(view_of(cloud), view_of(cloud), guess);
    return measured ? Vector6d(measured->covariance.diagonal().cwiseSqrt()) : Vector6d::Zero();
  };
  const Vector6d of_floor = sigmas(floor), of_room = sigmas(room(0.03));
  for (const int unmeasured : {0, 1, 5}) EXPECT_GT(of_floor[unmeasured], 10) << unmeasured;
  for (const int measured : {3, 4}) EXPECT_LT(of_floor[measured], 0.02) << measured;
  EXPECT_GT(of_room.minCoeff(), 0);
  EXPECT_LT(of_room.maxCoeff(), 0.02);
}

// What features and points say is weighed by the noise that smoothing has left.
TEST(LoopFinder, SmoothedPointsMakeASurerEdge) {
  Gallery gallery(3);
  LoopFinderSettings settings;
  settings.floor_translation = settings.floor_rotation = 1e-5;
  LoopFinder finder(settings);
  const KeyframeView from = gallery.seen_from(Eigen::Isometry3d::Identity());
  KeyframeView to = gallery.seen_from(se3_exp(twist(0.1, 0.05, -0.05, 0, 0.05, 0)));
  const auto as_noisy = finder.verify(from, to, std::nullopt);
  to.noise_left = 0.5;
  const auto smoothed = finder.verify(from, to, std::nullopt);
  ASSERT_TRUE(as_noisy && smoothed);
  const Vector6d shrunk = smoothed->covariance.diagonal().cwiseQuotient(as_noisy->covariance.diagonal());
  EXPECT_LT(shrunk.maxCoeff(), 0.9) << shrunk.transpose();
  EXPECT_GT(shrunk.minCoeff(), 0.25) << shrunk.transpose();
  EXPECT_FALSE(smoothed->T.isApprox(as_noisy->T, 1e-9));
}

// A poster that hangs in two rooms: its features and its points are the same, all around it is not.
TEST(LoopFinder, RefusesWhereTheFeaturesAgreeAndTheCloudsDoNot) {
  Gallery here(1);
  LoopFinder finder({});
  const KeyframeView view = here.seen_from(Eigen::Isometry3d::Identity());
  KeyframeView other_room = here.seen_from(Eigen::Isometry3d::Identity());
  ASSERT_TRUE(finder.verify(view, other_room, std::nullopt));
  for (std::size_t i = 0; i < other_room.cloud.size(); ++i)
    if (i % 5 != 0) other_room.cloud.points[i].z() += 2;
  EXPECT_FALSE(finder.verify(view, other_room, std::nullopt));
}

}  // namespace
}  // namespace lcmslam

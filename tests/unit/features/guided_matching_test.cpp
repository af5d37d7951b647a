#include <lcmslam/features/guided_matching.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include <lcmslam/features/descriptor_search.hpp>
#include "tests/support/heap_allocations.hpp"
#include "tests/unit/features/guided_scene.hpp"

namespace lcmslam {
namespace {

using namespace test;
using testing::HasSubstr;

TEST(GuidedMatching, FindsMoreThanTheWholeMapLetsPass) {
  int guided = 0, guided_right = 0, plain = 0, plain_right = 0;
  double innovations = 0;
  GuidedMatcher matcher;
  DescriptorSearch search({1, 1});
  constexpr int runs = 10;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Scene scene = make_scene(seed, 8000);
    ASSERT_EQ(scene.feature_of.size(), 300u);
    Random random(seed, 4);
    PredictedPose predicted;
    predicted.covariance = diagonal(0.02, 0.01);
    predicted.T_world_camera = scene.truth.T_world_camera * se3_exp(random_twist(random, 0.02, 0.01));
    const GuidedResult& found = matcher.match(scene.frame, predicted, scene.landmarks, scene.index);
    EXPECT_TRUE(found.supported()) << "seed " << seed;
    EXPECT_LT(found.by_chance, int(found.matches.size()) / 2) << "seed " << seed;
    innovations += found.mean_squared_innovation / runs;
    guided += int(found.matches.size());
    guided_right += count_right(scene, found.matches);
    const auto& whole = search.match(scene.frame.features, scene.index);
    plain += int(whole.size());
    plain_right += count_right(scene, whole);
  }
  std::printf(
      "[          ] guided: %d of %d right, whole map: %d of %d right; mean squared innovation %.2f\n",
      guided_right, guided, plain_right, plain, innovations);
  EXPECT_GT(guided_right, 2 * plain_right);
  EXPECT_GT(guided_right, 0.85 * guided);
  EXPECT_LT(innovations, 3);
}

TEST(GuidedMatching, AWrongPredictionIsReported) {
  GuidedMatcher matcher;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = make_scene(seed, 8000);
    Random random(seed, 5);
    PredictedPose wrong;
    wrong.covariance = diagonal(0.02, 0.01);
    Vector6d twist = random_twist(random, 0.02, 0.01);
    twist[3] += 0.3 + random.uniform();  // radians
    wrong.T_world_camera = scene.truth.T_world_camera * se3_exp(twist);
    const GuidedResult& found = matcher.match(scene.frame, wrong, scene.landmarks, scene.index);
    EXPECT_GT(found.in_view, 100) << "seed " << seed;
    EXPECT_FALSE(found.supported()) << "seed " << seed << ": " << found.matches.size() << ", by chance "
                                    << found.by_chance;
  }
}

TEST(GuidedMatching, AVaguePredictionIsReported) {
  const Scene scene = make_scene(1, 2000);
  PredictedPose vague = scene.truth;
  vague.covariance = diagonal(1, 1);
  GuidedMatcher matcher;
  const GuidedResult& found = matcher.match(scene.frame, vague, scene.landmarks, scene.index);
  EXPECT_GT(found.in_view, 20);
  EXPECT_EQ(found.too_vague, found.in_view);
  EXPECT_TRUE(found.matches.empty());
  EXPECT_FALSE(found.supported());
}

TEST(GuidedMatching, ALandmarkMappedTwiceIsNoRivalOfItself) {
  FeatureFrame frame = empty_frame();
  frame.features.resize(1);
  frame.features[0].x = 319.5f;
  frame.features[0].y = 239.5f;
  frame.features[0].descriptor.fill(128);
  DescriptorIndex index;
  std::vector<MapPoint> landmarks(2);
  for (int i = 0; i < 2; ++i) {
    landmarks[std::size_t(i)] = {i, {0, 0, 2}, 1e-4 * Eigen::Matrix3d::Identity()};
    index.insert(i, frame.features[0].descriptor, 0);
  }
  const PredictedPose pose{Eigen::Isometry3d::Identity(), diagonal(0.02, 0.02)};
  GuidedMatcher matcher;
  EXPECT_EQ(matcher.match(frame, pose, landmarks, index).matches.size(), 1u);
  landmarks[1].position.x() = 0.06;  // four standard deviations of the difference: another thing
  EXPECT_TRUE(matcher.match(frame, pose, landmarks, index).matches.empty());
}

TEST(GuidedMatching, EqualsDirectComparison) {
  const Scene scene = make_scene(3, 4000);
  PredictedPose predicted = scene.truth;
  predicted.covariance = diagonal(0.03, 0.02);
  const GuidedSettings settings;
  GuidedMatcher matcher;
  const GuidedResult& found = matcher.match(scene.frame, predicted, scene.landmarks, scene.index, settings);
  // Every pair whose innovation passes, without grid or boxes.
  std::vector<std::vector<std::pair<int, int>>> of_feature(scene.frame.features.size());
  std::map<int, std::vector<std::pair<int, int>>> of_landmark;
  int candidates = 0;
  for (const MapPoint& landmark : scene.landmarks) {
    const auto projection = project(landmark, predicted.T_world_camera, scene.frame);
    if (!projection) continue;
    const Eigen::Vector2d pixel = projection->pixel;
    if (pixel.x() < 0 || pixel.x() > 639 || pixel.y() < 0 || pixel.y() > 479) continue;
    const Eigen::Matrix2d S = innovation_covariance(*projection, landmark, predicted, scene.frame);
    if (std::sqrt(settings.chi_square * S.diagonal().maxCoeff()) > settings.max_gate) continue;
    for (std::size_t f = 0; f < scene.frame.features.size(); ++f) {
      const Feature& feature = scene.frame.features[f];
      if ((feature.laplacian >= 0) != scene.index.is_dark(landmark.id)) continue;
      const Eigen::Vector2d innovation = Eigen::Vector2d(feature.x, feature.y) - pixel;
      if (innovation.dot(S.inverse() * innovation) >= settings.chi_square) continue;
      ++candidates;
      const int d2 = squared_distance(feature.descriptor, scene.index.descriptor(landmark.id));
      of_feature[f].emplace_back(d2, landmark.id);
      of_landmark[landmark.id].emplace_back(d2, int(f));
    }
  }
  EXPECT_EQ(found.candidates, candidates);
  std::size_t expected = 0;
  for (std::size_t f = 0; f < of_feature.size(); ++f) {
    auto& offers = of_feature[f];
    if (offers.empty()) continue;
    std::sort(offers.begin(), offers.end());
    const int d2 = offers[0].first, id = offers[0].second;
    if (d2 > std::pow(127 * settings.max_distance, 2)) continue;
    const auto place = [&](int landmark) { return scene.landmarks[std::size_t(landmark / 5)].position; };
    const auto rival = std::find_if(offers.begin() + 1, offers.end(), [&](const auto& offer) {
      return (place(offer.second) - place(id)).squaredNorm() / 2e-4 >= 11.345;
    });
    if (rival != offers.end() && !(d2 < settings.ratio * settings.ratio * rival->first)) continue;
    auto& back = of_landmark[id];
    std::sort(back.begin(), back.end());
    if (back[0].second != int(f)) continue;
    if (back.size() > 1 && !(d2 < settings.ratio * settings.ratio * back[1].first)) continue;
    ASSERT_LT(expected, found.matches.size());
    EXPECT_EQ(found.matches[expected].a, int(f));
    EXPECT_EQ(found.matches[expected].b, id);
    EXPECT_EQ(found.matches[expected].distance2, d2);
    ++expected;
  }
  EXPECT_EQ(found.matches.size(), expected);
  EXPECT_GT(expected, 50u);
}

TEST(GuidedMatching, AllocatesNothingOnceWarm) {
  const Scene scene = make_scene(1, 2000);
  PredictedPose predicted = scene.truth;
  predicted.covariance = diagonal(0.02, 0.01);
  GuidedMatcher matcher;
  matcher.match(scene.frame, predicted, scene.landmarks, scene.index);
  const long before = heap_allocations();
  matcher.match(scene.frame, predicted, scene.landmarks, scene.index);
  EXPECT_EQ(heap_allocations(), before);
}

TEST(GuidedMatching, OddInputs) {
  Scene scene = make_scene(1, 500);
  scene.truth.covariance = diagonal(0.02, 0.01);
  GuidedMatcher matcher;
  scene.frame.features[0].x = NAN;
  scene.frame.features[1].y = -1e9f;
  scene.frame.features[2].x = 1e9f;
  scene.landmarks[0].position.setConstant(NAN);
  scene.landmarks[1].covariance.setConstant(INFINITY);
  EXPECT_FALSE(matcher.match(scene.frame, scene.truth, scene.landmarks, scene.index).matches.empty());
  EXPECT_TRUE(matcher.match(scene.frame, scene.truth, {}, scene.index).matches.empty());
  EXPECT_TRUE(matcher.match(empty_frame(), scene.truth, scene.landmarks, scene.index).matches.empty());

  const auto message = [&](auto change) -> std::string {
    FeatureFrame frame = scene.frame;
    PredictedPose pose = scene.truth;
    auto landmarks = scene.landmarks;
    GuidedSettings settings;
    change(frame, pose, landmarks, settings);
    try {
      matcher.match(frame, pose, landmarks, scene.index, settings);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  EXPECT_THAT(message([](auto& f, auto&, auto&, auto&) { f.fx = 0; }), HasSubstr("fx"));
  EXPECT_THAT(message([](auto& f, auto&, auto&, auto&) { f.width = 0; }), HasSubstr("no size"));
  EXPECT_THAT(message([](auto&, auto& p, auto&, auto&) { p.covariance(2, 3) = NAN; }),
              HasSubstr("not finite"));
  EXPECT_THAT(message([](auto&, auto& p, auto&, auto&) { p.covariance(1, 1) = -1; }), HasSubstr("negative"));
  EXPECT_THAT(message([](auto&, auto&, auto& l, auto&) { l[3].id = 4; }), HasSubstr("id 4 is not in"));
  EXPECT_THAT(message([](auto&, auto&, auto&, auto& s) { s.chi_square = 0; }), HasSubstr("chi_square is 0"));
  EXPECT_THAT(message([](auto&, auto&, auto&, auto& s) { s.ratio = 2; }), HasSubstr("ratio is 2"));
  EXPECT_THAT(message([](auto&, auto&, auto&, auto& s) { s.max_gate = NAN; }), HasSubstr("max_gate"));
}

}  // namespace
}  // namespace lcmslam

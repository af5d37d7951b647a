#include <lcmslam/messages/map_messages.hpp>

#include <gmock/gmock.h>

#include <numeric>

#include <lcmslam/graph_covariance_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tests/unit/messages/error_of.hpp"
#include "tests/unit/messages/samples.hpp"

namespace lcmslam {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr std::size_t largest_tile = 60'000;  // bytes, DESIGN: the bus

struct LandmarkCase {
  std::size_t landmarks, removed;
};

class LandmarkTiles : public ::testing::TestWithParam<LandmarkCase> {};

TEST_P(LandmarkTiles, HoldEveryLandmarkOnceAndStaySmall) {
  Random random(1);
  std::vector<Landmark> landmarks;
  for (std::size_t i = 0; i < GetParam().landmarks; ++i)
    landmarks.push_back(testing::some_landmark(random, static_cast<std::int64_t>(3 * i)));
  std::vector<std::int64_t> removed(GetParam().removed);
  std::iota(removed.begin(), removed.end(), std::int64_t{1} << 40);

  const auto tiles = make_landmark_tiles(99, 7, 6, landmarks, removed);
  std::vector<Landmark> back;
  std::vector<std::int64_t> removed_back;
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    const auto bytes = encode_message(tiles[k]);
    EXPECT_LE(bytes.size(), largest_tile);
    const auto tile = decode_message<landmarks_t>(bytes.data(), bytes.size());
    EXPECT_EQ(tile.utime, 99);
    EXPECT_EQ(tile.map_revision, 7);
    EXPECT_EQ(tile.base_revision, 6);
    EXPECT_EQ(tile.tile, static_cast<int>(k));
    EXPECT_EQ(tile.n_tiles, static_cast<int>(tiles.size()));
    for (const Landmark& landmark : landmarks_of(tile)) back.push_back(landmark);
    removed_back.insert(removed_back.end(), tile.removed.begin(), tile.removed.end());
  }
  EXPECT_EQ(removed_back, removed);
  ASSERT_EQ(back.size(), landmarks.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    EXPECT_EQ(back[i].id, landmarks[i].id);
    EXPECT_EQ(back[i].mean, landmarks[i].mean);
    EXPECT_TRUE(back[i].covariance.isApprox(landmarks[i].covariance, 1e-6));
    EXPECT_EQ(back[i].observations, landmarks[i].observations);
    EXPECT_EQ(back[i].colour, landmarks[i].colour);
    EXPECT_EQ(back[i].descriptor, landmarks[i].descriptor);
    EXPECT_EQ(back[i].laplacian, landmarks[i].laplacian);
    EXPECT_FLOAT_EQ(static_cast<float>(back[i].log_odds), static_cast<float>(landmarks[i].log_odds));
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, LandmarkTiles,
                         ::testing::Values(LandmarkCase{0, 0}, LandmarkCase{1, 2}, LandmarkCase{426, 0},
                                           LandmarkCase{427, 15}, LandmarkCase{1000, 30'000},
                                           LandmarkCase{0, 20'000}),
                         [](const auto& tested) {
                           return std::to_string(tested.param.landmarks) + "and" +
                                  std::to_string(tested.param.removed);
                         });

TEST(LandmarkMessages, ImpossibleTilesAreRefusedByName) {
  Random random(2);
  const landmarks_t good = make_landmark_tiles(1, 1, 0, {testing::some_landmark(random, 5)}, {}).front();
  const auto error_with = [&](auto change) {
    landmarks_t message = good;
    change(message);
    return error_of([&] { landmarks_of(message); });
  };
  EXPECT_EQ(error_with([](auto&) {}), "");
  EXPECT_THAT(error_with([](auto& m) { m.n_tiles = 0; }), HasSubstr("n_tiles"));
  EXPECT_THAT(error_with([](auto& m) { m.n_tiles = 2'000'000'000; }), HasSubstr("n_tiles"));
  EXPECT_THAT(error_with([](auto& m) { m.tile = 1; }), HasSubstr("tile"));
  EXPECT_THAT(error_with([](auto& m) { m.tile = -1; }), HasSubstr("tile"));
  EXPECT_THAT(error_with([](auto& m) { m.landmarks[0].mean[2] = std::nan(""); }), HasSubstr("landmark mean"));
  EXPECT_THAT(error_with([](auto& m) { m.landmarks[0].mean[0] = 1e30; }), HasSubstr("landmark mean"));
  EXPECT_THAT(error_with([](auto& m) { m.landmarks[0].covariance[3] = INFINITY; }),
              HasSubstr("landmark covariance"));
}

class KeyframeTiles : public ::testing::TestWithParam<std::size_t> {};

TEST_P(KeyframeTiles, MakeTheKeyframeAgainToHalfAMillimetre) {
  Random random(3);
  const DenseKeyframe keyframe = testing::some_keyframe(random, GetParam(), 30);
  const Eigen::Isometry3d T_robot_camera = testing::some_pose(random);
  DenseMap map;
  bool complete = false;
  for (const keyframe_t& tile : make_keyframe_tiles(keyframe, T_robot_camera, 4)) {
    EXPECT_FALSE(complete) << "complete before its last tile";
    const auto bytes = encode_message(tile);
    EXPECT_LE(bytes.size(), largest_tile);
    const auto received = decode_message<keyframe_t>(bytes.data(), bytes.size());
    EXPECT_EQ(received.map_revision, 4);
    EXPECT_TRUE(from_message(received).part.T_world_camera.isApprox(keyframe.T_world_camera, 1e-12));
    complete = map.add(from_message(received));
  }
  EXPECT_TRUE(complete);
  const DenseKeyframe& back = map.keyframes().at(keyframe.id);
  EXPECT_EQ(back.utime, keyframe.utime);
  ASSERT_EQ(back.cloud.size(), keyframe.cloud.size());
  for (std::size_t i = 0; i < back.cloud.size(); ++i) {
    const Eigen::Vector3f error = back.cloud.points[i] - keyframe.cloud.points[i];
    ASSERT_LE(error.cwiseAbs().maxCoeff(), 0.0005F + 1e-5F);
    ASSERT_EQ(back.cloud.colours[i], keyframe.cloud.colours[i]);
    const Eigen::Vector3f &n = back.cloud.normals[i], &m = keyframe.cloud.normals[i];
    ASSERT_EQ(n.allFinite(), m.allFinite());
    ASSERT_FALSE(n.dot(m) < std::cos(0.01)) << "1/127 of rounding";
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, KeyframeTiles, ::testing::Values(0, 1, 4833, 4834, 20'000));

TEST(KeyframeMessages, PointsThatDoNotFitAreLeftOut) {
  DenseKeyframe keyframe;
  const float nan_f = std::nanf("");
  for (const Eigen::Vector3f& p : {Eigen::Vector3f(0, 0, 31.9F), Eigen::Vector3f(0, -40, 1),
                                   Eigen::Vector3f(nan_f, 0, 1), Eigen::Vector3f(1, INFINITY, 1)}) {
    keyframe.cloud.points.push_back(p);
    keyframe.cloud.colours.emplace_back(1, 2, 3);
  }
  const auto tiles = make_keyframe_tiles(keyframe, Eigen::Isometry3d::Identity(), 1);
  ASSERT_EQ(tiles.size(), 1U);
  const KeyframeTile tile = from_message(tiles[0]);
  ASSERT_EQ(tile.part.cloud.size(), 1U);
  EXPECT_NEAR(tile.part.cloud.points[0].z(), 31.9, 5e-4);
  EXPECT_FALSE(tile.part.cloud.normals[0].allFinite());  // there was none
}

TEST(KeyframeMessages, ImpossibleTilesAreRefusedByName) {
  Random random(4);
  const keyframe_t good =
      make_keyframe_tiles(testing::some_keyframe(random, 5), Eigen::Isometry3d::Identity(), 1).front();
  const auto error_with = [&](auto change) {
    keyframe_t message = good;
    change(message);
    return error_of([&] { from_message(message); });
  };
  EXPECT_EQ(error_with([](auto&) {}), "");
  EXPECT_THAT(error_with([](auto& m) { m.n_tiles = 0; }), HasSubstr("n_tiles"));
  EXPECT_THAT(error_with([](auto& m) { m.tile = 7; }), HasSubstr("tile"));
  EXPECT_THAT(error_with([](auto& m) { m.resolution = 0; }), HasSubstr("resolution"));
  EXPECT_THAT(error_with([](auto& m) { m.resolution = std::nan(""); }), HasSubstr("resolution"));
  EXPECT_THAT(error_with([](auto& m) { m.n_values = 14; }), HasSubstr("multiple of 3"));
  EXPECT_THAT(error_with([](auto& m) { m.T_map_camera.quat[0] = std::nan(""); }), HasSubstr("T_map_camera"));
}

TEST(NodeCovariances, ComeBackWhole) {
  Random random(6);
  const Matrix6d covariance = testing::some_covariance(random);
  graph_covariance_t told{};
  told.frame = "map";
  told.nodes = {to_message(3, 2 * covariance), to_message(8, covariance)};
  told.n_nodes = 2;
  const auto bytes = encode_message(told);
  const auto back = decode_message<graph_covariance_t>(bytes.data(), bytes.size());
  ASSERT_EQ(back.nodes.size(), 2U);
  EXPECT_EQ(back.nodes[1].keyframe, 8);
  EXPECT_FLOAT_EQ(back.nodes[1].covariance[1], static_cast<float>(covariance(0, 1)));
  EXPECT_FLOAT_EQ(back.nodes[1].covariance[6], static_cast<float>(covariance(1, 1)));
  const Matrix6d found = from_message(back.nodes[1]);
  EXPECT_TRUE(found.isApprox(covariance, 1e-6));
  EXPECT_EQ(found, found.transpose());
}

TEST(NodeCovariances, ThatCannotBeAreRefused) {
  node_covariance_t m = to_message(3, Matrix6d::Identity());
  m.covariance[20] = -1;
  EXPECT_THAT(error_of([&] { from_message(m); }), HasSubstr("negative"));
  m.covariance[20] = std::nanf("");
  EXPECT_THAT(error_of([&] { from_message(m); }), HasSubstr("node covariance"));
}

}  // namespace
}  // namespace lcmslam

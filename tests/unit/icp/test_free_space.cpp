// What a depth image sees through leaves the map; walls, thin legs and noisy edges stay.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "icp/depth_view.hpp"
#include "icp/free_space.hpp"
#include "icp/icp_mapper.hpp"
#include "imaging/depth_filter.hpp"
#include "simulation/tof_camera.hpp"
#include "unit/icp/scenes.hpp"
#include "unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

/// What a camera at the origin sees of surfaces z(u, v), u, v in [-0.5, 0.5] at 0.01.
template <class Depth>
Cloud depth_image(const Depth& depth, float sigma = 0.005f) {
  Cloud cloud;
  for (int row = -50; row <= 50; ++row)
    for (int column = -50; column <= 50; ++column) {
      const float u = 0.01f * static_cast<float>(column), v = 0.01f * static_cast<float>(row);
      const float z = depth(u, v);
      if (z > 0) cloud.points.push_back(z * Eigen::Vector3f(u, v, 1)), cloud.sigmas.push_back(sigma);
    }
  return cloud;
}

const Eigen::Vector3f ahead(0, 0, -1);

TEST(FreeSpaceView, SeesThroughWhatIsClearlyBeforeTheMeasured) {
  const FreeSpaceView view(depth_image([](float, float) { return 3.0f; }), {});
  EXPECT_EQ(view.judge({0, 0, 2.9f}, ahead), Sight::seen_through);
  EXPECT_EQ(view.judge({0, 0, 2.96f}, ahead), Sight::supported);  // 5 cm and four sigmas
  EXPECT_EQ(view.judge({0, 0, 3.04f}, ahead), Sight::supported);
  EXPECT_EQ(view.judge({0, 0, 3.5f}, ahead), Sight::unknown);  // hidden
  EXPECT_EQ(view.judge({3, 0, 2}, ahead), Sight::unknown);     // beside the image
  EXPECT_EQ(view.judge({0, 0, -2}, ahead), Sight::unknown);
  // A slanting surface may err more along the ray.
  EXPECT_EQ(view.judge({0, 0, 2.9f}, Eigen::Vector3f(1, 0, -0.5f).normalized()), Sight::supported);
}

TEST(FreeSpaceView, NoiseCounts) {
  const FreeSpaceView view(depth_image([](float, float) { return 3.0f; }, 0.05f), {});
  EXPECT_EQ(view.judge({0, 0, 2.8f}, ahead), Sight::supported);
  EXPECT_EQ(view.judge({0, 0, 2.7f}, ahead), Sight::seen_through);
}

TEST(FreeSpaceView, HolesTellNothing) {
  const FreeSpaceView view(depth_image([](float u, float) { return std::abs(u) < 0.1f ? 0.0f : 3.0f; }), {});
  EXPECT_EQ(view.judge({0, 0, 2}, ahead), Sight::unknown);
  EXPECT_EQ(view.judge({0.17f, 0, 2}, ahead), Sight::unknown);  // at the hole's edge
  EXPECT_EQ(view.judge({0.6f, 0, 2}, ahead), Sight::seen_through);
  const FreeSpaceView nothing(Cloud(), {});
  EXPECT_EQ(nothing.judge({0, 0, 2}, ahead), Sight::unknown);
}

// Damaged points, and the last ones that a float holds.
TEST(FreeSpaceView, PointsFarOutDisturbNothing) {
  const Cloud wall = depth_image([](float, float) { return 3.0f; });
  Cloud more = wall;
  const float largest = std::numeric_limits<float>::max(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const Eigen::Vector3f& p :
       {Eigen::Vector3f(1e30f, 0, 0.1f), Eigen::Vector3f(-1e30f, 1e30f, 1), Eigen::Vector3f(largest, 0, 0.1f),
        Eigen::Vector3f(-largest, -largest, 0.5f), Eigen::Vector3f(30, 0, 1), Eigen::Vector3f(0, -30, 1),
        Eigen::Vector3f(nan, 0, 3), Eigen::Vector3f(0, nan, 3), Eigen::Vector3f(0, 0, nan),
        Eigen::Vector3f(0, 0, std::numeric_limits<float>::infinity())}) {
    more.points.push_back(p);
    more.sigmas.push_back(0.005f);
  }
  const FreeSpaceView plain(wall, {}), view(more, {});
  ASSERT_EQ(view.columns(), plain.columns());
  ASSERT_EQ(view.rows(), plain.rows());
  for (float x = -1.4f; x < 1.5f; x += 0.1f)
    for (float z = 2; z < 3.5f; z += 0.09f)
      EXPECT_EQ(view.judge({x, 0.3f, z}, ahead), plain.judge({x, 0.3f, z}, ahead)) << x << " " << z;
  EXPECT_EQ(view.judge({0, 0, 2.9f}, ahead), Sight::seen_through);
  // Far along a ray: nothing but what it sees through.
  more = wall;
  more.points.push_back({0, 0, 1e30f}), more.sigmas.push_back(0.005f);
  const FreeSpaceView deep(more, {});
  VoxelMap map;
  EXPECT_TRUE(map.look_through(deep, Eigen::Isometry3d::Identity(), {}, 0).empty());
  EXPECT_EQ(deep.judge({largest, 0, 0.1f}, ahead), Sight::unknown);
  EXPECT_EQ(deep.judge({0, 0, 2.9f}, ahead), Sight::seen_through);
}

TEST(FreeSpaceView, ThinThingsAndEdgesStay) {
  // A leg of 2 cm and the edge of a cupboard, 1.5 m away, before a wall: what the map knows of them lies up
  // to 2.5 cm beside them.
  const FreeSpaceView view(
      depth_image([](float u, float) { return std::abs(u) < 0.0067f || u > 0.2f ? 1.5f : 4.0f; }), {});
  for (float x = -0.025f; x <= 0.025f; x += 0.005f) {
    EXPECT_NE(view.judge({x, 0.1f, 1.45f}, ahead), Sight::seen_through) << x;
    EXPECT_NE(view.judge({0.3f + x, 0.1f, 1.45f}, ahead), Sight::seen_through) << x;
  }
  EXPECT_EQ(view.judge({0.15f, 0.1f, 1.45f}, ahead), Sight::seen_through);
}

TEST(FreeSpaceView, AGrazingFloorStays) {
  // 1.2 m below, up to 84 degrees.
  const FreeSpaceView view(depth_image([](float, float v) { return v > 0.1f ? 1.2f / v : 0.0f; }), {});
  int seen_through = 0, supported = 0;
  for (float z = 2.6f; z < 11; z += 0.1f)
    for (const float error : {-0.04f, 0.0f, 0.04f}) {
      const Sight sight = view.judge({0, 1.2f + error, z}, {0, -1, 0});
      seen_through += sight == Sight::seen_through ? 1 : 0;
      supported += sight == Sight::supported ? 1 : 0;
    }
  EXPECT_EQ(seen_through, 0);
  EXPECT_GT(supported, 100);
}

TEST(VoxelMapFreeSpace, WhatHasGoneGoesAndSupportKeeps) {
  Cloud wall, thing;
  add_rectangle(wall, {-2, -2, 3}, {0, 4, 0}, {4, 0, 0}, 0.03);
  add_rectangle(thing, {-0.3, -0.3, 2}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  VoxelMap map;
  for (int i = 0; i < 20; ++i) {
    map.insert(wall, Eigen::Vector3d::Zero());
    map.insert(thing, Eigen::Vector3d::Zero());
  }
  const std::size_t before = map.size();
  const FreeSpaceSettings settings;
  const FreeSpaceView empty(depth_image([](float, float) { return 3.0f; }), settings);
  const FreeSpaceView full(
      depth_image([](float u, float v) { return std::max(std::abs(u), std::abs(v)) < 0.15f ? 2.0f : 3.0f; }),
      settings);
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  const int all_rays = settings.rotation * settings.rotation;
  std::int32_t turn = 0;
  for (int i = 0; i < 3 * all_rays; ++i) EXPECT_TRUE(map.look_through(full, here, settings, turn++).empty());
  EXPECT_EQ(map.size(), before);
  TargetPoint found;
  ASSERT_TRUE(map.find({0, 0, 2}, 0.1f, found));
  std::size_t gone = 0;
  for (int i = 0; i < 8 * all_rays; ++i) gone += map.look_through(empty, here, settings, turn++).size();
  EXPECT_EQ(map.size(), before - gone);
  EXPECT_FALSE(map.find({0, 0, 2}, 0.1f, found));
  EXPECT_TRUE(map.find({0, 0, 3}, 0.1f, found));
  EXPECT_EQ(map.cloud().size(), map.size());
  for (const Eigen::Vector3f& p : map.cloud().points) EXPECT_NEAR(p.z(), 3, 0.01);
}

// Seen through once or twice: no partner for now, but there, and found again when a view supports it.
TEST(VoxelMapFreeSpace, WhatWasSeenThroughOnceIsDoubtful) {
  Cloud wall, thing;
  add_rectangle(wall, {-2, -2, 3}, {0, 4, 0}, {4, 0, 0}, 0.03);
  add_rectangle(thing, {-0.3, -0.3, 2}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  VoxelMapSettings map_settings;
  map_settings.dropped_at = -5;
  VoxelMap map(map_settings);
  map.insert(wall, Eigen::Vector3d::Zero());
  map.insert(thing, Eigen::Vector3d::Zero());
  FreeSpaceSettings settings;
  settings.rotation = 1;  // every ray in every turn
  auto look = [&, turn = 0](float z) mutable {
    const FreeSpaceView view(
        depth_image([&](float u, float v) { return std::max(std::abs(u), std::abs(v)) < 0.2f ? z : 3.0f; }),
        settings);
    return map.look_through(view, Eigen::Isometry3d::Identity(), settings, turn++).size();
  };
  const std::size_t before = map.size();
  TargetPoint found;
  ASSERT_TRUE(map.find({0, 0, 2}, 0.1f, found));
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(look(3), 0U);
    EXPECT_FALSE(map.find({0, 0, 2}, 0.1f, found)) << "evidence " << -1 - 2 * i;
    EXPECT_TRUE(map.find({0, 0, 3}, 0.1f, found));
    EXPECT_EQ(map.size(), before);
    EXPECT_EQ(map.cloud().size(), before);
    EXPECT_TRUE(map.partners_around({0, 0, 2}, 0.1).points.empty()) << "for the other kinds of targets";
    EXPECT_FALSE(map.partners_around({0, 0, 3}, 0.1).points.empty());
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(look(2), 0U);
  EXPECT_TRUE(map.find({0, 0, 2}, 0.1f, found)) << "supported again";
  EXPECT_EQ(map.size(), before);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(look(3), 0U);
  EXPECT_GT(look(3), 50U) << "0, -2, -4, gone";
  EXPECT_LT(map.size(), before);
}

// What moves through a bounded map leaves empty blocks, which are dropped before any place is forgotten.
TEST(VoxelMapFreeSpace, EmptyBlocksGoFirst) {
  Cloud wall, thing, more;
  add_rectangle(wall, {-2, -2, 3.02}, {0, 4, 0}, {4, 0, 0}, 0.03);
  add_rectangle(thing, {-0.9, -0.9, 2.02}, {0, 1.8, 0}, {1.8, 0, 0}, 0.03);
  add_rectangle(more, {-2, -2, -0.5}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  VoxelMap wall_alone;
  wall_alone.insert(wall, Eigen::Vector3d::Zero());
  VoxelMapSettings map_settings;
  map_settings.miss = 10;
  map_settings.max_blocks = static_cast<int>(wall_alone.blocks()) + 150;  // the thing is more than 100 blocks
  VoxelMap map(map_settings);
  map.insert(wall, Eigen::Vector3d::Zero());
  map.insert(thing, Eigen::Vector3d::Zero());
  ASSERT_LE(map.blocks(), static_cast<std::size_t>(map_settings.max_blocks));
  FreeSpaceSettings settings;
  settings.rotation = 1;
  const FreeSpaceView empty(depth_image([](float, float) { return 3.0f; }), settings);
  map.look_through(empty, Eigen::Isometry3d::Identity(), settings, 0);
  const std::size_t left = map.size();
  ASSERT_LT(left, wall_alone.size() + 200);
  map.insert(more, {-2, -2, -0.5});
  EXPECT_LT(map.blocks(), wall_alone.blocks() + 50);
  EXPECT_FALSE(map.has_forgotten());
  EXPECT_GT(map.size(), left + 100);
  TargetPoint found;
  EXPECT_TRUE(map.find({1.9f, 1.9f, 3}, 0.1f, found)) << "farthest from there";
}

// Two that are doubtful meet in a bent map: still doubtful, and not gone before a view takes them.
TEST(VoxelMapFreeSpace, EvidenceStaysInItsRangeWhereSurfelsMerge) {
  VoxelMapSettings map_settings;
  map_settings.miss = 70;
  map_settings.dropped_at = -100;  // the sum of two evidences leaves eight bits
  VoxelMap map(map_settings);
  Cloud thing;
  add_rectangle(thing, {-0.3, -0.3, 2.02}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  const Eigen::Isometry3d aside(Eigen::Translation3d(0, 0, -0.4));
  map.insert(thing, Eigen::Vector3d::Zero(), 0);
  map.insert(transformed(thing, aside), Eigen::Vector3d::Zero(), 1);
  FreeSpaceSettings settings;
  settings.rotation = 1;
  const FreeSpaceView empty(depth_image([](float, float) { return 3.0f; }), settings);
  ASSERT_TRUE(map.look_through(empty, Eigen::Isometry3d::Identity(), settings, 0).empty());
  VoxelMap bent = map.bent({Eigen::Isometry3d::Identity(), aside.inverse()});
  TargetPoint found;
  EXPECT_GT(bent.size(), 100U);
  EXPECT_FALSE(bent.find({0, 0, 2}, 0.1f, found)) << "both were seen through";
  EXPECT_GT(bent.look_through(empty, Eigen::Isometry3d::Identity(), settings, 1).size(), 100U);
}

/// A room with a thin-legged table, a cupboard, and a box that slides along the wall ahead.
class MovingBox : public testing::Test {
 protected:
  static constexpr int frames = 70, moving_from = 10, moving_to = 55;

  struct Run {
    Cloud map, published;  // both in the world of the first pose
    double error = 0;      // m, furthest
  };

  static double box_y(int frame) {
    const double share = std::clamp<double>(frame - moving_from, 0, moving_to - moving_from);
    return -1.1 + 2.3 * share / (moving_to - moving_from);
  }

  static Scene scene(double y) {
    std::string more =
        "boxes:\n"
        "  - {at: [2.9, 1.9, 0], size: [0.5, 0.6, 1.9], material: wall}\n"
        "  - {at: [3.0, 0.5, 0], size: [0.3, 0.3, 2.5], material: wall}\n"
        "  - {at: [3.0, -0.6, 0], size: [0.3, 0.4, 1.2], material: wall}\n"
        "  - {at: [1.9, -1.7, 0.7], size: [0.8, 0.6, 0.04], material: wall}\n";
    if (!std::isnan(y))
      more += "  - {at: [2.0, " + std::to_string(y) + ", 0.02], size: [0.4, 0.4, 1.1], material: red}\n";
    more += "cylinders:\n";
    for (const double x : {1.55, 2.25})
      for (const double leg_y : {-1.95, -1.45})
        more += "  - {at: [" + std::to_string(x) + ", " + std::to_string(leg_y) +
                ", 0], radius: 0.03, height: 0.7, material: wall}\n";
    return box_room(3.2, more);
  }

  static CameraModel wide_model() { return pinhole_camera(176, 144, 105); }

  static Eigen::Isometry3d robot(int frame) {
    const double phase = 2 * M_PI * frame / frames;
    return planar_pose(0.25 * (1 - std::cos(phase)), 0.15 * std::sin(phase), 0.12 * std::sin(2 * phase));
  }

  static Eigen::Isometry3d mount() {
    return Eigen::Translation3d(0, 0, 1.4) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()) *
           optical_axes();
  }

  // The images' clouds in the camera frame; without the box where `box` is false.
  static std::vector<Cloud> film(bool box) {
    RgbdCalibration calibration;
    calibration.colour = calibration.depth = wide_model();
    calibration.depth_noise = {0.003, 0, 0, 0.001};
    const DepthRegistration registration(calibration);
    DepthFilter filter(calibration);
    std::vector<Cloud> clouds;
    for (int i = 0; i < frames; ++i) {
      const Scene now = scene(box ? box_y(i) : std::nan(""));
      const RayCaster caster(now);
      const TofImage image =
          TofCamera(now, caster, wide_model()).render(robot(i) * mount(), PixelNoise(7, 1, i), 2);
      RgbdFrame frame;
      frame.depth = image.depth.clone();
      filter(frame.depth, image.grey);
      clouds.push_back(
          cloud_of(prepared_view(registration, frame, 1), Eigen::Isometry3d::Identity(), Vector6d::Zero()));
    }
    return clouds;
  }
  static const std::vector<Cloud>& with_box() {
    static const auto clouds = film(true);
    return clouds;
  }
  static const std::vector<Cloud>& without_box() {
    static const auto clouds = film(false);
    return clouds;
  }

  static Run run(const std::vector<Cloud>& clouds, bool free_space) {
    IcpMapperSettings settings;
    settings.free_space.enabled = free_space;
    IcpMapper mapper(settings);
    Run run;
    for (int i = 0; i < frames; ++i) {
      Motion motion;  // wheels that overrate every metre by two per cent
      if (i > 0) motion.T_from_to = robot(i - 1).inverse() * robot(i);
      motion.T_from_to.translation() *= 1.02;
      motion.covariance = 1e-4 * Matrix6d::Identity();
      ColouredCloud coloured;
      const Cloud& cloud = clouds[static_cast<std::size_t>(i)];
      coloured.points = cloud.points;
      coloured.normals = cloud.normals;
      coloured.sigmas = cloud.sigmas;
      coloured.colours.assign(cloud.size(), {10, 20, 30});
      const auto step = mapper.step(100'000 * (i + 1), coloured, mount(),
                                    i > 0 ? std::make_optional(motion) : std::nullopt);
      run.error = std::max(
          run.error, (robot(0).inverse() * robot(i) * step.T_world_robot.inverse()).translation().norm());
    }
    mapper.finish();
    run.map = mapper.map().cloud();
    for (const auto& keyframe : mapper.keyframes()) {
      const Cloud cloud = geometry_of(keyframe.cloud, keyframe.T_world_camera);
      run.published.points.insert(run.published.points.end(), cloud.points.begin(), cloud.points.end());
    }
    return run;
  }

  // Points where the box was but is not at the end; a hand away from what stays, whose edges make rays tell
  // nothing.
  static std::size_t trail(const Cloud& cloud) {
    const Eigen::AlignedBox3f swept(Eigen::Vector3f(1.7f, -1.0f, 0.16f), Eigen::Vector3f(2.3f, 0.75f, 1.3f));
    std::size_t count = 0;
    for (const Eigen::Vector3f& p : cloud.points) count += swept.contains(p) ? 1 : 0;
    return count;
  }

  // Share of the points of `truth` that have one of `cloud` within 5 cm.
  static double kept(const Cloud& truth, const Cloud& cloud, const Eigen::AlignedBox3f& where) {
    const KdTree tree(cloud.points);
    std::size_t asked = 0, found = 0;
    for (const Eigen::Vector3f& p : truth.points) {
      if (!where.contains(p)) continue;
      ++asked;
      found += tree.nearest(p, 0.05f).index >= 0 ? 1 : 0;
    }
    EXPECT_GT(asked, 50U);
    return static_cast<double>(found) / static_cast<double>(asked);
  }
};

TEST_F(MovingBox, LeavesNoTrail) {
  const Run plain = run(with_box(), false), free = run(with_box(), true);
  ASSERT_GT(trail(plain.map), 300U);
  ASSERT_GT(trail(plain.published), 300U);
  std::cout << "trail: map " << trail(plain.map) << " -> " << trail(free.map) << ", published "
            << trail(plain.published) << " -> " << trail(free.published) << "; errors " << plain.error << " "
            << free.error << "\n";
  EXPECT_LT(static_cast<double>(trail(free.map)), 0.02 * static_cast<double>(trail(plain.map)));
  EXPECT_LT(static_cast<double>(trail(free.published)), 0.02 * static_cast<double>(trail(plain.published)));
  EXPECT_LT(free.error, 0.03);
  // The box stands there at the end.
  const Eigen::AlignedBox3f box(Eigen::Vector3f(1.75f, 1.0f, 0.2f), Eigen::Vector3f(1.85f, 1.4f, 1));
  EXPECT_GT(kept(plain.map, free.map, box), 0.98);
}

TEST_F(MovingBox, WhatStandsStays) {
  const Run truth = run(without_box(), false), free = run(without_box(), true);
  const Eigen::AlignedBox3f all(Eigen::Vector3f::Constant(-10), Eigen::Vector3f::Constant(10));
  const Eigen::AlignedBox3f legs(Eigen::Vector3f(1.4f, -2.1f, 0.08f), Eigen::Vector3f(2.4f, -1.3f, 0.64f));
  for (const auto part : {&Run::map, &Run::published}) {
    EXPECT_GT(kept(truth.*part, free.*part, all), 0.995);
    EXPECT_GT(kept(truth.*part, free.*part, legs), 0.97);
    std::cout << "kept " << kept(truth.*part, free.*part, all) << ", legs "
              << kept(truth.*part, free.*part, legs) << ", points " << (truth.*part).size() << " -> "
              << (free.*part).size() << "\n";
  }
}

}  // namespace
}  // namespace lcmslam

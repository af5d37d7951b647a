// The whole mapper where a box moves: no trail of it stays, and what stands does.

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/rgbd/depth_view.hpp>
#include <lcmslam/simulation/tof_camera.hpp>
#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

/// A room with a thin-legged table, a cupboard, and a box that slides along the wall ahead.
class MovingBox : public testing::Test {
 protected:
  static constexpr int frames = 70, moving_from = 10, moving_to = 55;

  struct Run {
    Cloud map, published;  // both in the world of the first pose
    double error = 0;      // m, furthest
    int thinned = 0;       // times
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
      clouds.push_back(cloud_of(DepthPoints(registration.calibration()).thinned(frame, 1),
                                Eigen::Isometry3d::Identity(), Vector6d::Zero()));
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

  static Run run(const std::vector<Cloud>& clouds, bool free_space, DenseMapperSettings settings = {}) {
    settings.free_space.enabled = free_space;
    DenseMapper mapper(settings);
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
      const auto step = mapper.step(coloured_frame(100'000 * (i + 1), coloured, mount(),
                                                   i > 0 ? std::make_optional(motion) : std::nullopt));
      run.thinned += step.thinned ? 1 : 0;
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

// Keyframes that others cover leave their clouds to those, and no more of the box than all would have kept.
TEST_F(MovingBox, LeavesNoTrailInWhatThinnedKeyframesLeaveBehind) {
  DenseMapperSettings settings;
  settings.keyframe_distance = settings.keyframe_angle = 0.04;  // many that look at the same
  const Run all = run(with_box(), true, settings);
  settings.graph.max_keyframes = 5;
  const Run plain = run(with_box(), false, settings), free = run(with_box(), true, settings);
  EXPECT_EQ(all.thinned, 0);
  EXPECT_GT(free.thinned, 5);
  ASSERT_GT(trail(plain.published), 5'000U);
  EXPECT_LE(trail(free.published), trail(all.published));
  EXPECT_LT(static_cast<double>(trail(free.published)), 0.05 * static_cast<double>(trail(plain.published)));
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

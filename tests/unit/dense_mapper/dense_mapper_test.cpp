#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/geometry/rigid_alignment.hpp>
#include "tests/support/recorded_clouds.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/room_view.hpp"
#include "tests/unit/dense_mapper/drive.hpp"

namespace lcmslam {
namespace {

std::string name_of(const testing::TestParamInfo<CorrespondenceKind>& test) {
  static const char* const names[] = {"VoxelMap", "KdTree", "Projective"};
  return names[static_cast<std::size_t>(test.param)];
}

class EveryCorrespondence : public testing::TestWithParam<CorrespondenceKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryCorrespondence,
                         testing::Values(CorrespondenceKind::voxel_map, CorrespondenceKind::kd_tree,
                                         CorrespondenceKind::projective),
                         name_of);

// What a camera with 80 x 60 degrees sees of a cloud in its frame.
ColouredCloud in_view(const ColouredCloud& cloud) {
  ColouredCloud seen;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    if (p.z() < 0.2f || std::abs(p.x()) > 0.6f * p.z() || std::abs(p.y()) > 0.45f * p.z()) continue;
    seen.points.push_back(p);
    seen.normals.push_back(cloud.normals[i]);
    seen.sigmas.push_back(cloud.sigmas[i]);
    seen.colours.push_back(cloud.colours[i]);
  }
  return seen;
}

TEST_P(EveryCorrespondence, FollowsAKnownPathWithoutOdometry) {
  DenseMapperSettings settings;
  settings.correspondence = GetParam();
  DenseMapper mapper(settings);
  const Cloud scene = room(0.03);
  Eigen::Isometry3d looks_ahead = Eigen::Isometry3d::Identity();  // camera's z is the robot's x
  looks_ahead.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 20; ++i) {
    SCOPED_TRACE(i);
    const auto seed = static_cast<std::uint64_t>(i);
    const auto step = mapper.step(
        coloured_frame(i * frame_time, in_view(seen_from(scene, T * looks_ahead, seed)), looks_ahead));
    EXPECT_EQ(to_string(step.status), "tracking");
    expect_pose(step.T_world_robot, T, 0.01, 0.005);
    T = T * se3_exp(twist(0.02, 0.01, 0, 0, 0.005, 0.02));
  }
  EXPECT_GT(mapper.keyframes().size(), 1u);
}

// What has not had the time to be seen again is found none the less: there would be nothing to begin with.
TEST(DenseMapper, FollowsAPathByWhatWasSeenTwice) {
  DenseMapperSettings settings;
  settings.map.min_observations = 2;
  DenseMapper mapper(settings);
  const Cloud scene = room(0.03);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 15; ++i) {
    SCOPED_TRACE(i);
    const auto step = mapper.step(
        coloured_frame(i * frame_time, seen_from(scene, T, static_cast<std::uint64_t>(i)), no_mount));
    EXPECT_EQ(to_string(step.status), "tracking");
    expect_pose(step.T_world_robot, T, 0.01, 0.005);
    T = T * se3_exp(twist(0.02, 0.01, 0, 0, 0.005, 0.02));
  }
}

// A slip that exceeds what odometry states: registration wins where the scene fixes the pose.
TEST(DenseMapper, OvercomesAWheelSlip) {
  DenseMapperSettings settings;
  settings.prior.planar = true;
  DenseMapper mapper(settings);
  const Cloud scene = room(0.03);
  mapper.step(coloured_frame(0, seen_from(scene, no_mount, 1), no_mount));
  Motion slipped;
  slipped.T_from_to = planar_pose(0.05, 0.03, 0.04);  // in truth it stood still
  slipped.covariance = 1e-8 * Matrix6d::Identity();
  const auto step = mapper.step(coloured_frame(frame_time, seen_from(scene, no_mount, 2), no_mount, slipped));
  EXPECT_EQ(to_string(step.status), "tracking");
  expect_pose(step.T_world_robot, no_mount, 0.006, 0.004);
}

// Wheels that climb 10 cm and stand level there: nobody told the mapper.
TEST(DenseMapper, OnWheelsFollowsARampUpToALanding) {
  DenseMapperSettings settings;
  settings.prior.planar = true;
  settings.prior.ground.return_after = 4;
  DenseMapper mapper(settings);
  const Cloud scene = room(0.03);
  constexpr double step_length = 0.04;
  const auto steepness = [](int k) { return 0.14 * std::clamp(std::min(k - 5, 28 - k) / 3.0, 0.0, 1.0); };
  Eigen::Isometry3d T = no_mount;
  Motion wheels;
  wheels.T_from_to = planar_pose(step_length, 0, 0);
  wheels.covariance = 1e-6 * Matrix6d::Identity();
  for (int k = 0; k < 40; ++k) {
    const double along = k == 0 ? 0 : step_length, tilt = steepness(k);
    T.translation() += along * Eigen::Vector3d(std::cos(tilt), 0, std::sin(tilt));
    T.linear() = Eigen::AngleAxisd(-tilt, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const auto seed = static_cast<std::uint64_t>(k + 1);
    const auto step = mapper.step(coloured_frame(k * frame_time, seen_from(scene, T, seed), no_mount,
                                                 k == 0 ? std::nullopt : std::make_optional(wheels)));
    SCOPED_TRACE(k);
    EXPECT_EQ(to_string(step.status), "tracking");
    expect_pose(step.T_world_robot, T, 0.01, 0.008);
    if (k <= 5) {
      EXPECT_EQ(step.floor, Floor::plane);
    }
    if (k >= 9 && k <= 25) {
      EXPECT_EQ(step.floor, Floor::free);
    }
    if (k >= 36) {
      EXPECT_EQ(step.floor, Floor::level);
    }
  }
  EXPECT_GT(T.translation().z(), 0.09);
}

// A frame fits where its wheels cannot have led the robot, and tilted: it is lost, and its floor is where it
// was.
TEST(DenseMapper, WhatIsNotBelievedDoesNotTiltTheFloor) {
  DenseMapperSettings settings;
  settings.prior.planar = true;
  DenseMapper mapper(settings);
  const Cloud scene = room(0.03);
  mapper.step(coloured_frame(0, seen_from(scene, no_mount, 1), no_mount));
  Motion wheels;
  wheels.T_from_to = planar_pose(0.02, 0, 0);
  wheels.covariance = 1e-6 * Matrix6d::Identity();
  const Eigen::Isometry3d tilted = se3_exp(twist(0.2, 0, 0, 0, 0.05, 0));
  const auto step = mapper.step(coloured_frame(frame_time, seen_from(scene, tilted, 2), no_mount, wheels));
  EXPECT_EQ(to_string(step.status), "lost");
  EXPECT_GT(rotation_angle(step.registration.T_target_source), 0.03) << "it would fit there";
  EXPECT_EQ(step.floor, Floor::plane);
}

TEST(DenseMapper, FollowsOdometryAlongABareWall) {
  DenseMapperSettings settings;
  settings.prior.planar = true;
  DenseMapper mapper(settings);
  const Cloud scene = wall(0.03);
  mapper.step(coloured_frame(0, seen_from(scene, no_mount, 1), no_mount));
  Motion motion;
  motion.T_from_to = planar_pose(0, 0.1, 0);
  motion.covariance = 1e-6 * Matrix6d::Identity();
  const auto step =
      mapper.step(coloured_frame(frame_time, seen_from(scene, motion.T_from_to, 2), no_mount, motion));
  EXPECT_FALSE(step.registration.degenerate.empty());
  expect_pose(step.T_world_robot, motion.T_from_to, 0.01, 0.01);
}

TEST(DenseMapper, GarbageIsLostAndTheMapIsLeftAlone) {
  DenseMapper mapper;
  const Cloud scene = room(0.03);
  EXPECT_EQ(to_string(mapper.step(coloured_frame(0, {}, no_mount)).status), "initialising");
  mapper.step(coloured_frame(frame_time, seen_from(scene, no_mount, 1), no_mount));
  const std::size_t before = mapper.map().size();

  ColouredCloud not_finite = seen_from(scene, no_mount, 2);
  for (auto& p : not_finite.points) p.setConstant(std::numeric_limits<float>::quiet_NaN());
  ColouredCloud coincident = seen_from(scene, no_mount, 3);
  for (auto& p : coincident.points) p = Eigen::Vector3f(1, 0, 0);
  ColouredCloud no_normals = seen_from(scene, no_mount, 4);
  no_normals.normals.clear();
  const ColouredCloud elsewhere = seen_from(sphere({3, 2, 2}, 0.5), no_mount, 5);
  Utime utime = 2 * frame_time;
  for (const ColouredCloud& cloud : {ColouredCloud{}, not_finite, coincident, no_normals, elsewhere}) {
    const auto step = mapper.step(coloured_frame(utime += frame_time, cloud, no_mount));
    EXPECT_EQ(to_string(step.status), "lost");
    EXPECT_TRUE(step.T_world_robot.matrix().allFinite());
    EXPECT_TRUE(step.covariance.allFinite());
    EXPECT_EQ(mapper.map().size(), before);
  }
  // And it comes back.
  const auto step = mapper.step(coloured_frame(utime + frame_time, seen_from(scene, no_mount, 6), no_mount));
  EXPECT_EQ(to_string(step.status), "tracking");
  expect_pose(step.T_world_robot, no_mount, 0.01, 0.005);
}

TEST(DenseMapper, RecoversAtAKeyframeAfterAJump) {
  DenseMapper mapper;
  const Cloud scene = room(0.03);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Utime utime = 0;
  for (int i = 0; i < 25; ++i) {
    mapper.step(
        coloured_frame(utime += frame_time, seen_from(scene, T, static_cast<std::uint64_t>(i)), no_mount));
    T = T * se3_exp(twist(0.03, 0, 0, 0, 0, 0.03));
  }
  // Carried back to the start while the camera was covered.
  for (int i = 0; i < 3; ++i) mapper.step(coloured_frame(utime += frame_time, {}, no_mount));
  DenseMapper::Step step;
  for (int i = 0; i < 5; ++i)
    step = mapper.step(coloured_frame(utime += frame_time, seen_from(scene, no_mount, 77), no_mount));
  EXPECT_EQ(to_string(step.status), "tracking");
  expect_pose(step.T_world_robot, no_mount, 0.02, 0.01);
  const GraphEdge& way = mapper.graph().edges().back();
  EXPECT_EQ(way.to, static_cast<int>(mapper.graph().nodes().size()) - 1);
  EXPECT_EQ(way.from, 0) << "how it came there nobody knows";
}

// From far aside nothing is near, and without features nothing is recognised; surfaces are the same.
TEST(DenseMapper, ComparesANodeWithTheKeyframeWhoseSurfacesItShows) {
  const auto loops_to_the_first = [](int shown) {
    DenseMapperSettings settings;
    settings.keyframe_distance = 0.1;
    settings.graph.max_distance = 0.5;
    settings.graph.shown = shown;
    settings.graph.vague = 0;
    DenseMapper mapper(settings);
    const Cloud scene = room(0.03);
    for (int i = 0; i < 60; ++i)
      mapper.step(coloured_frame(
          i * frame_time, seen_from(scene, planar_pose(-0.03 * i, 0, 0), static_cast<std::uint64_t>(i)),
          no_mount));
    mapper.finish();
    const std::vector<GraphEdge>& edges = mapper.graph().edges();
    return std::count_if(edges.begin(), edges.end(),
                         [](const GraphEdge& e) { return e.kind == EdgeKind::loop && e.from == 0; });
  };
  EXPECT_GT(loops_to_the_first(2), 0);
  EXPECT_EQ(loops_to_the_first(0), 0);
}

// Against motion capture; the stretch turns fast and comes back.
TEST(DenseMapper, TracksAHandHeldRecording) {
  const auto recording = Fr1Recording::open();
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  ASSERT_TRUE(recording);
  const std::size_t first = 100;
  const auto run = [&](std::size_t count) {
    DenseMapper mapper;
    std::vector<DenseMapper::Step> steps;
    for (std::size_t i = first; i < first + count; ++i)
      steps.push_back(mapper.step(coloured_frame(recording->utime(i), recording->cloud(i), optical_axes())));
    return steps;
  };
  const auto steps = run(60);
  std::vector<Eigen::Vector3d> found, truth;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    EXPECT_EQ(to_string(steps[k].status), "tracking") << k;
    found.emplace_back((steps[k].T_world_robot * optical_axes()).translation());
    truth.emplace_back(recording->T_world_camera(first + k).translation());
  }
  const auto T_truth_world = align_svd(found, truth);
  ASSERT_TRUE(T_truth_world);
  double squares = 0;
  for (std::size_t k = 0; k < found.size(); ++k)
    squares += (*T_truth_world * found[k] - truth[k]).squaredNorm();
  EXPECT_LT(std::sqrt(squares / static_cast<double>(found.size())), 0.03);
  constexpr std::size_t half_second = 15;
  for (std::size_t k = half_second; k < steps.size(); ++k) {
    const Eigen::Isometry3d moved = optical_axes().inverse() *
                                    steps[k - half_second].T_world_robot.inverse() * steps[k].T_world_robot *
                                    optical_axes();
    const Eigen::Isometry3d expected =
        recording->T_world_camera(first + k - half_second).inverse() * recording->T_world_camera(first + k);
    EXPECT_LT(rotation_angle(expected.inverse() * moved), 0.10) << k;
  }
  const auto again = run(10);
  for (std::size_t k = 0; k < again.size(); ++k)
    EXPECT_TRUE(again[k].T_world_robot.matrix() == steps[k].T_world_robot.matrix());
}

}  // namespace
}  // namespace lcmslam

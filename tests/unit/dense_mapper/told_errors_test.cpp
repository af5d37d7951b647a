// How wrong the 6-D mapper says its poses and its graph's nodes are.

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/support/room_view.hpp"

namespace lcmslam {
namespace {

constexpr Utime frame_period = 100'000;

// Registration errs beside the newest node by what is stated, whatever the graph has learned from how edges
// between other views contradict each other.
TEST(ToldErrors, APoseErrsBesideItsNodeAsStated) {
  DenseMapperSettings settings;
  settings.graph.optimiser.stated_measurements = 0.5;  // so that what is learned counts
  DenseMapper mapper(settings);
  const Cloud scene = room(0.03);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double learned = 1, told = 0;
  for (int i = 0; i < 60; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const auto step = mapper.step(
        coloured_frame(i * frame_period, seen_from(scene, T, seed), Eigen::Isometry3d::Identity()));
    const double along = i < 30 ? 0.03 : -0.03;
    T = T * se3_exp(twist(along, 0, 0, 0, 0, along));
    const double factor = mapper.graph().error_factors().edges;
    if (step.node || std::abs(factor - 1) < 0.3) continue;
    const KeyframeGraph::Node& node = mapper.graph().nodes().back();
    const Matrix6d A = adjoint(step.T_world_robot.inverse() * node.T_world_camera);
    const Matrix6d beside = step.map_covariance - A * node.error.covariance() * A.transpose();
    const double sigmas = settings.graph.optimiser.frame_error;
    EXPECT_LT((beside - sigmas * sigmas * step.covariance).norm(), 1e-6 * beside.norm()) << i;
    learned = factor;
    told = beside.norm();
  }
  EXPECT_NE(learned, 1);
  EXPECT_GT(told, 0);
}

// A robot that drives in a bow: the same in all but what is told.
TEST(ToldErrors, APoseErrsByTheHeadsPlaceToo) {
  DenseMapperSettings exact;
  exact.mount_error = {0, 0};
  DenseMapper mapper, sure(exact);
  const Cloud scene = room(0.03);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity(), mount = Eigen::Isometry3d::Identity();
  mount.translation() << 0.2, 0, 0.5;
  for (int i = 0; i < 15; ++i) {
    const auto frame =
        coloured_frame(i * frame_period, seen_from(scene, T, static_cast<std::uint64_t>(i)), mount);
    const auto step = mapper.step(frame), other = sure.step(frame);
    ASSERT_EQ(step.T_world_robot.matrix(), other.T_world_robot.matrix());
    const KeyframeGraph::Node& node = mapper.graph().nodes().back();
    const Eigen::Isometry3d T_now = step.T_world_robot * mount,
                            T_first = mapper.graph().nodes().front().T_world_camera;
    const Matrix6d expected =
        mount_error(T_first.inverse() * T_now, mount, MountErrorSettings().sigmas(mount),
                    adjoint(T_now.inverse() * node.T_world_camera) * node.error.by_mount);
    EXPECT_LT((step.map_covariance - other.map_covariance - expected).norm(),
              1e-9 * step.map_covariance.norm() + 1e-15);
    if (i == 14) {
      EXPECT_GT(expected.norm(), 1e-7);
    }
    T = T * se3_exp(twist(0.03, 0, 0, 0, 0, 0.05));
  }
}

// As the robot's pose does that stands there, carried to the camera.
TEST(ToldErrors, ANodeErrsAsTheRobotThatStandsThere) {
  DenseMapper mapper;
  const Cloud scene = room(0.03);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity(), mount = Eigen::Isometry3d::Identity();
  mount.translation() << 0.2, 0, 0.5;
  const Matrix6d A = adjoint(mount);
  const auto told = [&](std::size_t i) {
    return (A * mapper.node_covariance(mapper.graph().nodes()[i], mount) * A.transpose()).eval();
  };
  for (int i = 0; i < 25; ++i) {
    const auto step = mapper.step(
        coloured_frame(i * frame_period, seen_from(scene, T, static_cast<std::uint64_t>(i)), mount));
    T = T * se3_exp(twist(0.03, 0, 0, 0, 0, 0.05));
    // Before the graph has solved anything the newest one errs as the pose that was told with it.
    if (!step.node || mapper.graph().nodes().size() > 2) continue;
    EXPECT_LT((told(mapper.graph().nodes().size() - 1) - step.map_covariance).norm(),
              1e-9 * step.map_covariance.norm() + 1e-15);
  }
  mapper.finish();
  ASSERT_GT(mapper.graph().nodes().size(), 3U);
  EXPECT_LT(told(0).norm(), 1e-15);  // the map begins there
  const Eigen::Isometry3d T_first = mapper.graph().nodes().front().T_world_camera;
  for (std::size_t i = 1; i < mapper.graph().nodes().size(); ++i) {
    const KeyframeGraph::Node& node = mapper.graph().nodes()[i];
    const Matrix6d expected = A * node.map_error.own * A.transpose() +
                              mount_error(T_first.inverse() * node.T_world_camera, mount,
                                          MountErrorSettings().sigmas(mount), node.map_error.by_mount);
    EXPECT_GT(expected.norm(), 1e-9);
    EXPECT_LT((told(i) - expected).norm(), 1e-9 * expected.norm());
  }
}

}  // namespace
}  // namespace lcmslam

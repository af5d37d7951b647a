// What the 6-D mapper found, as messages.

#include "procs/icp/icp_messages.hpp"

#include <gtest/gtest.h>

#include <lcmslam/messages/map_messages.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/support/room_view.hpp"

namespace lcmslam {
namespace {

Eigen::Isometry3d bow_mount() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.2, 0, 0.5;
  return T;
}

/// A robot drives through a room in a bow.
void drive(DenseMapper& mapper) {
  const Cloud scene = room(0.03);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 25; ++i) {
    mapper.step(coloured_frame(100'000 * i, seen_from(scene, T, static_cast<std::uint64_t>(i)), bow_mount()));
    T = T * se3_exp(twist(0.03, 0, 0, 0, 0, 0.05));
  }
}

TEST(GraphCovariance, IsOfTheNodesThatTheGraphsMessageNames) {
  DenseMapper mapper;
  drive(mapper);
  graph_t told = icp_graph(mapper.graph());
  ASSERT_GT(told.nodes.size(), 3U);
  told.utime = 17;
  told.frame = "map-2";
  told.nodes = {told.nodes[2], told.nodes[1]};
  told.n_nodes = 2;
  const graph_covariance_t message = icp_graph_covariance(mapper, told, bow_mount());
  EXPECT_EQ(message.utime, 17);
  EXPECT_EQ(message.frame, "map-2");
  ASSERT_EQ(message.nodes.size(), 2U);
  EXPECT_EQ(message.n_nodes, 2);
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_EQ(message.nodes[i].keyframe, told.nodes[i].keyframe);
    const KeyframeGraph::Node& node = mapper.graph().nodes()[2 - i];
    const Matrix6d expected = mapper.node_covariance(node, bow_mount());
    EXPECT_TRUE(from_message(message.nodes[i]).isApprox(expected, 1e-6)) << i;
  }
}

}  // namespace
}  // namespace lcmslam

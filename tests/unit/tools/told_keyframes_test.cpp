// Keyframes as a log's last graph has them.

#include "tools/study/told_keyframes.hpp"

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/graph_covariance_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "tests/unit/messages/graph_samples.hpp"
#include "tests/unit/messages/samples.hpp"

namespace lcmslam {
namespace {

class ToldKeyframesTest : public ::testing::Test {
 protected:
  template <class M>
  void tell(const std::string& channel, const M& message) {
    told_.hear(channel, encode_message(message));
  }

  void tell_graph(const std::vector<graph_node_t>& nodes, const Matrix6d& covariance,
                  const std::string& frame = "map") {
    graph_t graph = testing::graph_of(seq_++, nodes, {});
    graph.frame = frame;
    tell("ICP_GRAPH", graph);
    graph_covariance_t covariances{};
    covariances.frame = frame;
    for (const graph_node_t& node : nodes) covariances.nodes.push_back(to_message(node.keyframe, covariance));
    covariances.n_nodes = static_cast<std::int32_t>(nodes.size());
    tell("ICP_GRAPH_COVARIANCE", covariances);
  }

  void tell_cloud(std::int32_t id, const std::string& frame = "map") {
    keyframe_t tile{};
    tile.frame = frame;
    tile.id = id;
    tile.T_map_camera = testing::node(id, 0).T_map_camera;
    tile.T_robot_camera = to_message(mount_);
    tell("ICP_KEYFRAME", tile);
  }

  Random random_{1};
  Eigen::Isometry3d mount_ = testing::some_pose(random_);
  Matrix6d covariance_ = testing::some_covariance(random_);
  ToldKeyframes told_;
  std::int64_t seq_ = 0;
};

TEST_F(ToldKeyframesTest, AreTheRobotsPosesAndErrorsAsToldLast) {
  tell_graph({testing::node(0, 0), testing::node(2, 5)}, 9 * covariance_);
  for (const int id : {2, 0}) tell_cloud(id);
  tell_graph({testing::node(0, 0), testing::node(1, 1), testing::node(2, 2)}, covariance_);
  const Trajectory path = told_.path();
  ASSERT_EQ(path.size(), 2U);  // 1 only keeps the path's place
  EXPECT_EQ(path[0].utime, 0);
  EXPECT_EQ(path[1].utime, 2000);
  const Eigen::Isometry3d T(Eigen::Translation3d(2, 0, 0));
  EXPECT_TRUE(path[1].T_world_body.isApprox(T * mount_.inverse(), 1e-9));
  const Matrix6d A = adjoint(mount_);
  ASSERT_TRUE(path[1].covariance.has_value());
  EXPECT_TRUE(path[1].covariance->isApprox(A * covariance_ * A.transpose(), 1e-5));
}

TEST_F(ToldKeyframesTest, AreThoseOfTheFirstMap) {
  tell_graph({testing::node(0, 0), testing::node(1, 1)}, covariance_);
  for (const int id : {0, 1}) tell_cloud(id);
  tell_graph({testing::node(0, 7), testing::node(2, 9)}, 4 * covariance_, "map-2");
  tell_cloud(2, "map-2");
  const Trajectory path = told_.path();
  ASSERT_EQ(path.size(), 2U);
  const Matrix6d A = adjoint(mount_);
  EXPECT_TRUE(path[0].covariance->isApprox(A * covariance_ * A.transpose(), 1e-5));
}

}  // namespace
}  // namespace lcmslam

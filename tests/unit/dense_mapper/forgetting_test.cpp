// A bounded map that forgets what is far, and keyframes that give it back.

#include <gtest/gtest.h>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

/// A hall along x, 14 m long, with cupboards of different depths on both sides: every place looks different.
Cloud hall() {
  Cloud cloud;
  Random random(8);
  add_rectangle(cloud, {-1, -1.5, -1}, {16, 0, 0}, {0, 3, 0});
  for (int i = -1; i < 15; ++i) {
    const double left = random.uniform(0.9, 1.5), right = random.uniform(0.9, 1.5), x = i;
    add_rectangle(cloud, {x, left, -1}, {1, 0, 0}, {0, 0, 2});
    add_rectangle(cloud, {x, left, -1}, {0, 0, 2}, {0, 1.6 - left, 0});
    add_rectangle(cloud, {x, -right, -1}, {0, 0, 2}, {1, 0, 0});
    add_rectangle(cloud, {x, -right, -1}, {0, 0, 2}, {0, right - 1.6, 0});
  }
  return cloud;
}

class Forgetting : public testing::Test {
 protected:
  Forgetting() { looks_ahead_.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0; }

  // Up to 3 m ahead, 90 degrees wide.
  ColouredCloud seen_at(double x) {
    ColouredCloud cloud;
    const Eigen::Isometry3f T = (planar_pose(x, 0, 0) * looks_ahead_).inverse().cast<float>();
    for (std::size_t i = 0; i < hall_.size(); ++i) {
      const Eigen::Vector3f p = T * hall_.points[i];
      if (p.z() < 0.3f || p.z() > 3 || std::abs(p.x()) > p.z() || std::abs(p.y()) > p.z()) continue;
      const Eigen::Vector3f n = T.linear() * hall_.normals[i];
      cloud.points.push_back(p + static_cast<float>(random_.normal(0, 0.003)) * n);
      cloud.normals.push_back(n.dot(p) < 0 ? n : Eigen::Vector3f(-n));
      cloud.sigmas.push_back(0.003f);
      cloud.colours.emplace_back(10, 20, 30);
    }
    return cloud;
  }

  DenseMapper::Step go_to(DenseMapper& mapper, double x) {
    Motion motion;  // wheels that overrate every metre by two per cent
    motion.T_from_to.translation().x() = 1.02 * (x - x_);
    motion.covariance = 4e-4 * Matrix6d::Identity();
    const bool first = utime_ == 0;
    utime_ += 100'000;
    const auto step = mapper.step(
        coloured_frame(utime_, seen_at(x), looks_ahead_, first ? std::nullopt : std::make_optional(motion)));
    x_ = x;
    return step;
  }

  // Share of the hall's walls between two metres that the map knows.
  double known(const DenseMapper& mapper, double from, double to) const {
    int asked = 0, found = 0;
    TargetPoint point;
    for (const Eigen::Vector3f& p : hall_.points) {
      if (p.x() < from || p.x() > to || p.z() < -0.5f || p.z() > 0.5f) continue;
      ++asked;
      found += mapper.map().find(p, 0.08f, point) ? 1 : 0;
    }
    return static_cast<double>(found) / asked;
  }

  const Cloud hall_ = hall();
  Eigen::Isometry3d looks_ahead_ = Eigen::Isometry3d::Identity();
  Random random_{5};
  Utime utime_ = 0;
  double x_ = 0;
  static constexpr double first_ = 0.15;  // m, where the long run begins
};

TEST_F(Forgetting, KeyframesGiveBackWhatTheMapForgot) {
  DenseMapperSettings settings;
  settings.map.max_blocks = 2200;
  DenseMapper mapper(settings);
  double known_first = 0;
  for (double x = 0; x < 9.95; x += 0.1) {
    const auto step = go_to(mapper, x);
    ASSERT_EQ(to_string(step.status), "tracking") << x;
    ASSERT_LE(mapper.map().blocks(), 2200U);
    if (x < 2.4) known_first = known(mapper, 0.7, 1.9);
  }
  EXPECT_GT(known_first, 0.4);  // faces that look the other way are never seen
  ASSERT_TRUE(mapper.map().has_forgotten());
  EXPECT_LT(known(mapper, 0.7, 1.9), 0.1);
  // Backwards: what lies behind has not been in view again when it is known again.
  double known_before_seen = 0;
  for (double x = x_ - 0.1; x > -0.05; x -= 0.1) {
    const auto step = go_to(mapper, x);
    ASSERT_EQ(to_string(step.status), "tracking") << x;
    EXPECT_LE(mapper.map().blocks(), 2200U);
    EXPECT_NEAR(step.T_world_robot.translation().x(), x, 0.06);
    EXPECT_LT(step.T_world_robot.translation().tail<2>().norm(), 0.06);
    if (x > 2.0 && x < 2.4) known_before_seen = std::max(known_before_seen, known(mapper, 0.7, 1.9));
  }
  EXPECT_GT(known_before_seen, 0.85 * known_first);
  // Home again, in the map of the beginning.
  const auto home = go_to(mapper, 0);
  EXPECT_GT(home.registration.overlap, 0.9);
  EXPECT_NEAR(home.T_world_robot.translation().x(), 0, 0.03);
}

TEST_F(Forgetting, KeyframesKeepABoundedNumberOfPoints) {
  DenseMapperSettings settings;
  settings.keyframe_points = 20000;
  DenseMapper mapper(settings);
  const auto points = [&] {
    std::size_t sum = 0;
    for (const auto& keyframe : mapper.keyframes()) sum += keyframe.cloud.size();
    return sum;
  };
  for (double x = 0; x < 8; x += 0.1) {
    go_to(mapper, x);
    EXPECT_LE(points(), 20000U);
  }
  ASSERT_GT(mapper.keyframes().size(), 15U);
  EXPECT_GT(points(), 10000U);
  // The far ones gave most.
  EXPECT_GT(mapper.keyframes().front().voxel, 2 * settings.keyframe_voxel);
  EXPECT_EQ(mapper.keyframes().back().voxel, settings.keyframe_voxel);
  EXPECT_GT(mapper.keyframes().back().cloud.size(), 4 * mapper.keyframes().front().cloud.size());
}

// Hours in one building: to and fro, with fewer keyframes than the way would have.
TEST_F(Forgetting, FewKeyframesStayAndTheFirstPlaceIsKnown) {
  DenseMapperSettings settings;
  settings.graph.max_keyframes = 20;
  settings.map.max_blocks = 2200;
  settings.keyframe_points = 150'000;
  DenseMapper mapper(settings);
  std::vector<std::size_t> bytes;
  std::size_t most = 0, most_nodes = 0;
  bool thinned = false;
  constexpr int laps = 8;
  for (int lap = 0; lap < laps; ++lap) {
    for (int i = 1; i <= 120; ++i) {
      const double x = 0.15 * (i <= 60 ? i : 120 - i);
      const auto step = go_to(mapper, x);
      ASSERT_EQ(to_string(step.status), "tracking") << lap << " " << x;
      EXPECT_NEAR(step.T_world_robot.translation().x(), x - first_, 0.08) << lap;
      thinned = thinned || step.thinned;
      most = std::max(most, mapper.keyframes().size());
      most_nodes = std::max(most_nodes, mapper.graph().nodes().size());
      for (const auto& keyframe : mapper.keyframes())
        ASSERT_LT(static_cast<std::size_t>(keyframe.node), mapper.graph().nodes().size());
    }
    bytes.push_back(mapper.memory_bytes());
    std::size_t points = 0;
    for (const auto& keyframe : mapper.keyframes()) points += keyframe.cloud.size();
    EXPECT_LT(static_cast<double>(points), 1.2 * settings.keyframe_points) << lap;  // and what joined since
  }
  EXPECT_TRUE(thinned);
  EXPECT_LE(most, 21U);
  EXPECT_LE(most_nodes, 46U);  // some come while the graph is at work
  EXPECT_GT(mapper.keyframes_made(), 30);
  std::cout << "bytes after each lap:";
  for (const std::size_t b : bytes) std::cout << " " << b;
  std::cout << ", keyframes " << mapper.keyframes_made() << "\n";
  const auto half = bytes.begin() + laps / 2;
  EXPECT_LT(static_cast<double>(*std::max_element(half, bytes.end())),
            1.1 * static_cast<double>(*std::max_element(bytes.begin(), half)));
  // What the map forgets comes back from the keyframes that are left, and places the robot.
  const auto home = go_to(mapper, 0.15);
  EXPECT_GT(home.registration.overlap, 0.9);
  EXPECT_NEAR(home.T_world_robot.translation().x(), 0.15 - first_, 0.06);
  // Points of keyframes that went are their neighbours' now.
  mapper.finish();
  ASSERT_GT(mapper.keyframes().size(), 10U);
  Cloud published;
  for (const auto& keyframe : mapper.keyframes()) {
    const Cloud cloud = geometry_of(keyframe.cloud, keyframe.T_world_camera);
    published.points.insert(published.points.end(), cloud.points.begin(), cloud.points.end());
  }
  int asked = 0, found = 0;
  const KdTree tree(published.points);
  for (const Eigen::Vector3f& p : hall_.points) {
    if (p.z() > -0.9f || std::abs(p.y()) > 0.8f || p.x() < 2 || p.x() > 9) continue;  // the floor
    ++asked;
    found += tree.nearest(p - Eigen::Vector3f(static_cast<float>(first_), 0, 0), 0.08f).index >= 0 ? 1 : 0;
  }
  EXPECT_GT(asked, 100);
  EXPECT_GT(found, 0.97 * asked);
}

}  // namespace
}  // namespace lcmslam

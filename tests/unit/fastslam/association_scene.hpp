#pragma once
// A map made from a world's true points, and what the robot sees from one pose.

#include <algorithm>
#include <cmath>
#include <vector>

#include <lcmslam/fastslam/association/landmark_matcher.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam {

struct AssociationScene {
  FastSlamSettings settings;
  std::vector<synthetic::Point> points;
  ParticleMap map;
  LandmarkIndex index;
  FeatureFrame frame;
  std::vector<int> truth;  // slot of each feature
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();

  explicit AssociationScene(std::uint64_t seed, synthetic::WorldSettings world = {}) {
    Random random(seed);
    points = synthetic::make_points(world, random);
    for (std::size_t i = 0; i < points.size(); ++i) {
      Feature f;
      f.descriptor = synthetic::noisy_bytes(points[i].descriptor, 0, random);
      f.laplacian = points[i].laplacian;
      map.edit(static_cast<std::size_t>(index.add(f, settings))) = {points[i].position,
                                                                    1e-4 * Eigen::Matrix3d::Identity()};
    }
    T_world_robot = synthetic::true_pose(world, static_cast<int>(random.below(400)));
    frame = synthetic::see(world, points, T_world_robot, random, truth);
  }

  // Sought within three sigma of 96 pixels.
  std::vector<LandmarkMatch> match(const std::vector<FeaturePoint>& usable) const {
    Matrix6d Q = Matrix6d::Zero();
    Q.diagonal().tail<3>().setConstant(std::pow(96 / (3 * frame.fx), 2));
    LandmarkMatcher matcher;
    matcher.begin(frame, usable);
    return matcher.guided(visible_landmarks(map, index, T_world_robot, frame, settings), map, index,
                          T_world_robot, Q, settings);
  }

  int right(const std::vector<FeaturePoint>& usable, const std::vector<LandmarkMatch>& matches) const {
    return static_cast<int>(std::count_if(matches.begin(), matches.end(), [&](const LandmarkMatch& m) {
      const int feature = usable[static_cast<std::size_t>(m.point)].feature;
      return truth[static_cast<std::size_t>(feature)] == m.slot;
    }));
  }
};

}  // namespace lcmslam

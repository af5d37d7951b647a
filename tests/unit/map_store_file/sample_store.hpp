#pragma once
// What the tests of the map file put into it.

#include <lcmslam/map_store/file/store_changes.hpp>
#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {

inline Landmark some_landmark(std::uint64_t seed, std::int64_t id) {
  Random random(seed);
  Landmark mark = landmark(id, random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0, 2));
  mark.covariance(0, 1) = mark.covariance(1, 0) = 0.003;
  mark.log_odds = 2.5;
  mark.laplacian = -1;
  for (auto& byte : mark.descriptor) byte = static_cast<std::uint8_t>(random.below(256));
  return mark;
}

inline DenseKeyframe some_keyframe(std::int32_t id, std::size_t points = 40) {
  const auto seed = static_cast<std::uint64_t>(id) + 100;
  Random random(seed);
  return {id, 1000 * id, lcmslam::random_pose(random), random_cloud(seed, points, true), 1};
}

/// Every second one without depth.
inline FeatureFrame some_frame_of_features(std::uint64_t seed, int count) {
  Random random(seed);
  FeatureFrame frame;
  frame.utime = 123'456;
  frame.seq = 9;
  frame.sensor = "kitchen's head";
  frame.width = 640;
  frame.height = 480;
  frame.fx = frame.fy = 525.5;
  frame.has_mount = true;
  frame.T_robot_camera = lcmslam::random_pose(random);
  for (int i = 0; i < count; ++i) {
    Feature feature;
    feature.x = static_cast<float>(random.uniform(0, 640));
    feature.laplacian = 1;
    if (i % 2 == 1) {
      feature.kind = MeasurementKind::point;
      feature.point = random_point(random).cast<float>();
      feature.depth_sigma = 0.01F;
    }
    for (auto& byte : feature.descriptor) byte = static_cast<std::uint8_t>(random.below(256));
    frame.features.push_back(feature);
  }
  return frame;
}

inline StoredImages some_images(std::uint64_t seed) {
  Random random(seed);
  StoredImages images;
  images.frame.utime = 1000;
  images.frame.seq = 3;
  images.frame.sensor = "head";
  images.T_colour_depth_time = lcmslam::random_pose(random);
  images.frame.colour = {1000, 4, 2, ImageCoding::jpeg, {1, 2, 3, 4, 5}};
  images.frame.depth = {1016, 4, 2, ImageCoding::depth_zlib, {9, 8, 7}};
  return images;
}

inline StoredSession session_of(const std::string& mapper, std::int64_t sender = 7) {
  return {0, mapper, sender, "map"};
}

inline StoredEdge edge_between(std::int32_t from, std::int32_t to) {
  StoredEdge edge;
  edge.from = from;
  edge.to = to;
  edge.sigma_translation = 0.01F;
  return edge;
}

}  // namespace lcmslam

#pragma once
// A camera among landmarks of known places, and what it sees of them.

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <lcmslam/features/guided_matching.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam::test {

inline Vector6d random_twist(Random& random, double translation, double rotation) {
  Vector6d twist;
  for (int k = 0; k < 6; ++k) twist[k] = (k < 3 ? translation : rotation) * random.normal();
  return twist;
}

inline Matrix6d diagonal(double translation, double rotation) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(translation * translation),
      Eigen::Vector3d::Constant(rotation * rotation);
  return variances.asDiagonal();
}

inline FeatureFrame empty_frame() {
  FeatureFrame frame;
  frame.width = 640;
  frame.height = 480;
  frame.fx = 525;
  frame.fy = 520;
  frame.cx = 319.5;
  frame.cy = 239.5;
  frame.pixel_sigma = 1;
  return frame;
}

struct Scene {
  FeatureFrame frame = empty_frame();
  std::vector<MapPoint> landmarks;
  DescriptorIndex index;
  std::map<int, int> feature_of;  // landmark: the feature that shows it
  PredictedPose truth;
};

inline Descriptor texture(std::uint64_t kind, double spread, Random& random) {
  Random pattern(kind, 7);
  Descriptor descriptor;
  for (auto& byte : descriptor)
    byte = std::uint8_t(
        std::lround(std::clamp(128 + 16 * pattern.normal() + spread * random.normal(), 1., 255.)));
  return descriptor;
}

// Landmarks all around the camera, only some 400 different textures among them: a building whose windows
// look alike. 300 of those in view are seen, and 200 other blobs.
inline Scene make_scene(std::uint64_t seed, int count) {
  Random random(seed, 3);
  Scene scene;
  scene.truth.T_world_camera = se3_exp(random_twist(random, 0.5, 0.5));
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
    MapPoint landmark{5 * i, random.uniform(2, 6) * direction.normalized(),
                      1e-4 * Eigen::Matrix3d::Identity()};
    const std::uint64_t kind = random.below(400);
    const int laplacian = kind % 2 ? 1 : -1;
    scene.index.insert(landmark.id, texture(kind, 4, random), laplacian);
    scene.landmarks.push_back(landmark);
    const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
    MapPoint actual = landmark;
    actual.position += 0.01 * noise;
    const auto projection = project(actual, scene.truth.T_world_camera, scene.frame);
    if (!projection || scene.feature_of.size() >= 300) continue;
    Feature feature;
    feature.x = float(projection->pixel.x() + random.normal());
    feature.y = float(projection->pixel.y() + random.normal());
    if (feature.x < 0 || feature.x > 639 || feature.y < 0 || feature.y > 479) continue;
    feature.laplacian = std::int8_t(laplacian);
    feature.descriptor = scene.index.descriptor(landmark.id);
    for (auto& byte : feature.descriptor)
      byte = std::uint8_t(std::lround(std::clamp(byte + 6 * random.normal(), 1., 255.)));
    scene.feature_of[landmark.id] = int(scene.frame.features.size());
    scene.frame.features.push_back(feature);
  }
  for (int i = 0; i < 200; ++i) {
    Feature feature;
    feature.x = float(random.uniform(0, 639));
    feature.y = float(random.uniform(0, 479));
    const std::uint64_t kind = random.below(400);
    feature.laplacian = kind % 2 ? 1 : -1;
    feature.descriptor = texture(kind, 4, random);
    scene.frame.features.push_back(feature);
  }
  return scene;
}

inline int count_right(const Scene& scene, const std::vector<Match>& matches) {
  int right = 0;
  for (const Match& m : matches) {
    const auto seen = scene.feature_of.find(m.b);
    right += seen != scene.feature_of.end() && seen->second == m.a;
  }
  return right;
}

}  // namespace lcmslam::test

#pragma once
// What keyframes see in tests of the graph.

#include <vector>

#include <lcmslam/pose_graph/loop_finder.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {

inline constexpr Utime one_second = 1'000'000;  // us

/// A long wall of things: each has a descriptor of its own and a surface.
class Gallery {
 public:
  explicit Gallery(std::uint64_t seed) : random_(seed) {
    for (int i = 0; i < 1500; ++i) {
      points_.emplace_back(random_.uniform(-2, 8), random_.uniform(-1, 1), random_.uniform(2, 3.5));
      normals_.push_back(
          Eigen::Vector3d(random_.normal(), random_.normal(), -std::abs(random_.normal()) - 0.3)
              .normalized());
      Descriptor descriptor;
      for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(256 * random_.uniform());
      descriptors_.push_back(descriptor);
    }
  }

  KeyframeView seen_from(const Eigen::Isometry3d& T_world_camera) {
    KeyframeView view;
    FeatureFrame& f = view.features;
    f.width = 640;
    f.height = 480;
    f.fx = f.fy = 525;
    f.cx = 319.5;
    f.cy = 239.5;
    const Eigen::Isometry3d T = T_world_camera.inverse();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d p = T * points_[i];
      if (std::abs(p.x()) > 0.6 * p.z() || std::abs(p.y()) > 0.45 * p.z()) continue;
      const Eigen::Vector3d noise(random_.normal(), random_.normal(), random_.normal());
      Feature feature;
      feature.kind = MeasurementKind::point;
      feature.point = (p + 0.003 * noise).cast<float>();
      feature.depth_sigma = 0.003f;
      feature.descriptor = descriptors_[i];
      f.features.push_back(feature);
      view.cloud.points.push_back(feature.point);
      view.cloud.normals.emplace_back((T.linear() * normals_[i]).cast<float>());
      view.cloud.sigmas.push_back(0.003f);
    }
    return view;
  }

 private:
  Random random_;
  std::vector<Eigen::Vector3d> points_, normals_;
  std::vector<Descriptor> descriptors_;
};

}  // namespace lcmslam

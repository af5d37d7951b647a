#pragma once
// A furnished room of planes and boxes: what a camera in it measures of its surfaces and of things that can
// be told apart, with the noise that it says it has.

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/places/place_index.hpp>
#include "tests/support/analytic_scene.hpp"

namespace lcmslam::testing_scene {

struct Seen {
  Eigen::Isometry3d T_room_camera;
  FeatureFrame features;
  ColouredCloud cloud;
};

class Room {
 public:
  /// 6 m x 5 m x 2.5 m from the corner at the origin. `things`: seed of what it looks like; rooms of the same
  /// seed are twins.
  explicit Room(std::uint64_t things, std::uint64_t noise = 1) : noise_(noise, 5) {
    scene.planes = {{{1, 0, 0}, 0}, {{1, 0, 0}, 6}, {{0, 1, 0}, 0},
                    {{0, 1, 0}, 5}, {{0, 0, 1}, 0}, {{0, 0, 1}, 2.5}};
    Random random(things);
    const auto box = [&](double x, double y, double height) {
      const double width = random.uniform(0.4, 0.9), depth = random.uniform(0.3, 0.6);
      scene.boxes.emplace_back(Eigen::Vector3d(x, y, 0), Eigen::Vector3d(x + width, y + depth, height));
    };
    for (const double x : {0.4, 2.2, 4.6}) {
      box(x, 0.1, random.uniform(0.5, 1.8));
      box(x + 0.3, 4.3, random.uniform(0.5, 1.8));
    }
    box(5.0, 2.2, random.uniform(0.6, 1.2));
    while (things_.size() < 1500) {
      const double x = random.normal(), y = random.normal(), z = random.normal();
      const Eigen::Vector3d middle(3, 2.5, 1.2), ray = Eigen::Vector3d(x, y, z).normalized();
      Thing thing{middle + scene.hit(middle, ray) * ray, {}, random.uniform() < 0.5 ? -1 : 1};
      for (auto& byte : thing.descriptor) byte = static_cast<std::uint8_t>(20 + 216 * random.uniform());
      things_.push_back(thing);
    }
  }

  /// A camera 1.3 m above the floor that looks down a little.
  static Eigen::Isometry3d camera(double x, double y, double heading) {
    return planar_pose(x, y, heading) * Eigen::Translation3d(0, 0, 1.3) *
           Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitY()) * optical_axes();
  }

  /// Where keyframes of a round tour through the room look from.
  static std::vector<Eigen::Isometry3d> tour() {
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i < 12; ++i) {
      const double angle = i * 0.5236;
      poses.push_back(camera(3 + 0.6 * std::cos(angle), 2.5 + 0.6 * std::sin(angle), angle));
    }
    return poses;
  }

  Seen seen_from(const Eigen::Isometry3d& T_room_camera) {
    Seen seen{T_room_camera, {}, {}};
    FeatureFrame& f = seen.features;
    f.width = 640;
    f.height = 480;
    f.fx = f.fy = 525;
    f.cx = 319.5;
    f.cy = 239.5;
    f.pixel_sigma = 0.5;
    for (int v = 4; v < f.height; v += 8)
      for (int u = 4; u < f.width; u += 8) {
        const Eigen::Vector3d ray((u - f.cx) / f.fx, (v - f.cy) / f.fy, 1);
        const double z = scene.hit(T_room_camera.translation(), T_room_camera.linear() * ray);
        seen.cloud.points.emplace_back(((z + depth_sigma * noise_.normal()) * ray).cast<float>());
        seen.cloud.colours.emplace_back(128, 128, 128);
        seen.cloud.sigmas.push_back(static_cast<float>(depth_sigma));
      }
    for (const Thing& thing : things_) add_feature(thing, T_room_camera, f);
    return seen;
  }

  /// Keyframes of the tour under keys from `first`, at T_map_room.
  void map(PlaceIndex& index, const Eigen::Isometry3d& T_map_room = Eigen::Isometry3d::Identity(),
           std::int64_t first = 0) {
    for (const Eigen::Isometry3d& T : tour()) {
      const Seen seen = seen_from(T);
      index.add(first++, T_map_room * T, seen.features, seen.cloud);
    }
  }

  Scene scene;

 private:
  static constexpr double depth_sigma = 0.004;  // m
  struct Thing {
    Eigen::Vector3d point;
    Descriptor descriptor;
    int laplacian;
  };

  void add_feature(const Thing& thing, const Eigen::Isometry3d& T_room_camera, FeatureFrame& frame) {
    const Eigen::Vector3d p = T_room_camera.inverse() * thing.point;
    if (p.z() < 0.3) return;
    Feature feature;
    feature.x = static_cast<float>(frame.fx * p.x() / p.z() + frame.cx + frame.pixel_sigma * noise_.normal());
    feature.y = static_cast<float>(frame.fy * p.y() / p.z() + frame.cy + frame.pixel_sigma * noise_.normal());
    if (!(feature.x >= 0 && feature.x < 640 && feature.y >= 0 && feature.y < 480)) return;
    const double z = scene.hit(T_room_camera.translation(), T_room_camera.linear() * (p / p.z()));
    if (z < p.z() - 0.02) return;  // hidden
    const Eigen::Vector3d ray((static_cast<double>(feature.x) - frame.cx) / frame.fx,
                              (static_cast<double>(feature.y) - frame.cy) / frame.fy, 1);
    feature.point = ((p.z() + depth_sigma * noise_.normal()) * ray).cast<float>();
    feature.depth_sigma = static_cast<float>(depth_sigma);
    feature.kind = MeasurementKind::point;
    feature.laplacian = static_cast<std::int8_t>(thing.laplacian);
    feature.response = static_cast<float>(thing.descriptor[0]);
    for (std::size_t i = 0; i < thing.descriptor.size(); ++i)
      feature.descriptor[i] = static_cast<std::uint8_t>(thing.descriptor[i] + noise_.uniform(-3, 3));
    frame.features.push_back(feature);
  }

  Random noise_;
  std::vector<Thing> things_;
};

}  // namespace lcmslam::testing_scene

#pragma once
// Views of the simulated kitchen as the graph tells them: features with their points, and the cloud.

#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam::testing {

struct SeenView {
  const images_t* images = nullptr;
  FeatureFrame features;
  ColouredCloud cloud;  ///< camera frame
  Eigen::Isometry3d T_world_camera;

  /// No place of the kitchen, though all of it looks like one.
  SeenView mirrored() const {
    SeenView view = *this;
    for (Feature& f : view.features.features) f.point.x() *= -1;
    for (Eigen::Vector3f& p : view.cloud.points) p.x() *= -1;
    for (Eigen::Vector3f& n : view.cloud.normals) n.x() *= -1;
    return view;
  }
};

/// Of SimulatedKitchen's frame of this number; made once.
inline const SeenView& seen_view(int number) {
  static std::map<int, SeenView> known;
  const auto found = known.find(number);
  if (found != known.end()) return found->second;
  SimulatedKitchen& kitchen = SimulatedKitchen::instance();
  const RgbdCalibration& calibration = kitchen.simulation().calibration();
  const images_t& images = kitchen.frame(number);
  const RgbdFrame frame = decode_images(images, calibration);
  const auto T_world_camera = [&](Utime at) {
    return kitchen.simulation().T_world_robot(at) * calibration.T_robot_camera;
  };
  const RegisteredDepth depth = register_depth(
      frame, calibration,
      T_world_camera(frame.utime).inverse() * T_world_camera(calibration.depth_time(frame.depth_utime)));
  SurfSettings settings;
  settings.hessian_threshold = 5;
  settings.budget.max_features = 400;
  Surf surf(settings);
  return known[number] = {&images, describe_frame(frame, depth, calibration, surf),
                          make_cloud(frame, depth, 2), T_world_camera(frame.utime)};
}

}  // namespace lcmslam::testing

// The whole mapper where something goes ahead of the robot at its speed: it stands still in the images.

#include <gtest/gtest.h>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/rgbd/depth_view.hpp>
#include <lcmslam/simulation/tof_camera.hpp>
#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

Eigen::Isometry3d robot_behind_a_box(int frame) {
  return planar_pose(-1.2 + 0.03 * frame, 0.1, 0);
}

ColouredCloud seen_behind_a_box(int frame, int from, const DepthRegistration& registration) {
  const CameraModel model = registration.calibration().depth;
  const double x = -1.2 + 0.03 * frame + 1.3;
  const std::string box =
      "  - {at: [" + std::to_string(x) + ", -0.2, 0], size: [0.4, 0.6, 1.6], material: red}\n";
  const Scene scene = box_room(3.5,
                               "boxes:\n"
                               "  - {at: [2.9, 1.9, 0], size: [0.5, 0.6, 1.9], material: wall}\n"
                               "  - {at: [2.2, -1.9, 0], size: [0.3, 0.4, 1.2], material: wall}\n" +
                                   (frame >= from ? box : ""));
  const RayCaster caster(scene);
  RgbdFrame image;
  image.depth = TofCamera(scene, caster, model)
                    .render(robot_behind_a_box(frame) * level_camera(), PixelNoise(3, 1, frame), 2)
                    .depth;
  const Cloud cloud = cloud_of(DepthPoints(registration.calibration()).thinned(image, 1),
                               Eigen::Isometry3d::Identity(), Vector6d::Zero());
  ColouredCloud seen;
  seen.points = cloud.points;
  seen.normals = cloud.normals;
  seen.sigmas = cloud.sigmas;
  seen.colours.assign(cloud.size(), {10, 20, 30});
  return seen;
}

// Wheels that overrate the way by two per cent: 2.4 cm at the end, which the room corrects.
double strays_behind_a_box(int settled_after) {
  constexpr int frames = 40, from = 12;
  RgbdCalibration calibration;
  calibration.colour = calibration.depth = pinhole_camera(176, 144, 105);
  calibration.depth_noise = {0.003, 0, 0, 0.001};
  const DepthRegistration registration(calibration);
  DenseMapperSettings settings;
  settings.map.settled_after = settled_after;
  DenseMapper mapper(settings);
  double furthest = 0;
  for (int i = 0; i < frames; ++i) {
    Motion motion;
    if (i > 0) motion.T_from_to = robot_behind_a_box(i - 1).inverse() * robot_behind_a_box(i);
    motion.T_from_to.translation() *= 1.02;
    motion.covariance = 1e-6 * Matrix6d::Identity();
    const auto step =
        mapper.step(coloured_frame(100'000 * (i + 1), seen_behind_a_box(i, from, registration),
                                   level_camera(), i > 0 ? std::make_optional(motion) : std::nullopt));
    EXPECT_EQ(to_string(step.status), "tracking") << i;
    furthest = std::max(furthest, distance_between(step.T_world_robot,
                                                   robot_behind_a_box(0).inverse() * robot_behind_a_box(i)));
  }
  return furthest;
}

TEST(BoxAhead, TakesNobodyAlong) {
  const double strays = strays_behind_a_box(DenseMapperSettings().map.settled_after);
  const double when_all_lead_alike = strays_behind_a_box(1);
  std::cout << "strays by " << strays << " m, " << when_all_lead_alike << " where all surfaces lead alike\n";
  EXPECT_LT(strays, 0.015);
  EXPECT_GT(when_all_lead_alike, 2 * strays);
}

}  // namespace
}  // namespace lcmslam

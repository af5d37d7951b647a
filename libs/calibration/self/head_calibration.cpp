#include <lcmslam/calibration/self/head_calibration.hpp>

#include <lcmslam/calibration/self/aligned_sightings.hpp>

namespace lcmslam {

void continue_at(const SceneObservations& adjusted, const RgbdCalibration& head, SceneObservations& scene) {
  for (SightedLandmark& landmark : scene.landmarks) {
    const LandmarkSighting& sighting = landmark.sightings[landmark.sightings.size() / 2];
    const auto k = static_cast<std::size_t>(sighting.keyframe);
    const double z = (scene.keyframes[k].T_world_camera.inverse() * landmark.point).z();
    landmark.point = adjusted.keyframes[k].T_world_camera * (z * head.colour.ray(sighting.pixel));
  }
  for (std::size_t k = 0; k < scene.keyframes.size(); ++k)
    scene.keyframes[k].T_world_camera = adjusted.keyframes[k].T_world_camera;
}

BundleResult calibrate_head(HeadModel& model, SceneObservations& scene, const CalibrationPriors& priors,
                            const BundleSettings& settings) {
  SceneObservations tracked = scene;
  align_sightings(scene, model.calibration());
  const int rounds = adjust_bundle(model, scene, priors, settings).rounds;
  continue_at(scene, model.calibration(), tracked);
  scene = std::move(tracked);
  align_sightings(scene, model.calibration());
  BundleResult result = adjust_bundle(model, scene, priors, settings);
  result.rounds += rounds;
  return result;
}

}  // namespace lcmslam

#include <lcmslam/calibration/self/head_calibration.hpp>

#include <lcmslam/calibration/self/aligned_sightings.hpp>

namespace lcmslam {
namespace {

/// Keyframes as they were adjusted; each landmark goes with the one that its texture is taken from.
void move_to(const SceneObservations& adjusted, SceneObservations& scene) {
  for (SightedLandmark& landmark : scene.landmarks) {
    const auto k = static_cast<std::size_t>(landmark.sightings[landmark.sightings.size() / 2].keyframe);
    landmark.point =
        adjusted.keyframes[k].T_world_camera * (scene.keyframes[k].T_world_camera.inverse() * landmark.point);
  }
  for (std::size_t k = 0; k < scene.keyframes.size(); ++k)
    scene.keyframes[k].T_world_camera = adjusted.keyframes[k].T_world_camera;
}

}  // namespace

BundleResult calibrate_head(HeadModel& model, SceneObservations& scene, const CalibrationPriors& priors,
                            const BundleSettings& settings) {
  SceneObservations tracked = scene;
  align_sightings(scene, model.calibration());
  const int rounds = adjust_bundle(model, scene, priors, settings).rounds;
  move_to(scene, tracked);
  scene = std::move(tracked);
  align_sightings(scene, model.calibration());
  BundleResult result = adjust_bundle(model, scene, priors, settings);
  result.rounds += rounds;
  return result;
}

}  // namespace lcmslam

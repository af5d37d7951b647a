#pragma once
// A head from what a recording shows of it.

#include <lcmslam/calibration/self/bundle_adjustment.hpp>

namespace lcmslam {

/// Puts the keyframes of `scene` where `adjusted`, a copy of it, found them, and each landmark on the ray of
/// the pixel that its texture is taken from, as `head` has it, as deep as that keyframe first saw it.
void continue_at(const SceneObservations& adjusted, const RgbdCalibration& head, SceneObservations& scene);

/// Finds the textures of `scene`'s landmarks again in each image and adjusts all of it; then once more by the
/// head that was found: one that is 1 degree off takes edges of depth for surfaces, and bends textures
/// wrongly. `scene`: as RecordedScene gives it, and as it was adjusted. Throws as adjust_bundle().
BundleResult calibrate_head(HeadModel& model, SceneObservations& scene, const CalibrationPriors& priors,
                            const BundleSettings& settings);

}  // namespace lcmslam

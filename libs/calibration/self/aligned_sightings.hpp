#pragma once
#include <vector>

#include <lcmslam/calibration/self/patch_alignment.hpp>
#include <lcmslam/calibration/self/scene_observations.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// Puts a landmark's sightings where the texture of the middle one lies in the other images; those that do
/// not show it leave, and all of a landmark at an edge of depth.
void align_sightings(SightedLandmark& landmark, const std::vector<ObservedKeyframe>& keyframes,
                     const RgbdCalibration& head);

/// Each landmark so; those that too few sightings are left of leave.
void align_sightings(SceneObservations& scene, const RgbdCalibration& head);

}  // namespace lcmslam

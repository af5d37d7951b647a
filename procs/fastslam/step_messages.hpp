#pragma once
// A step of the filter as messages.

#include <lcmslam/associations_t.hpp>
#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/particles_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {

/// Without map_revision and processing_time.
pose_estimate_t pose_message(Utime utime, const StepResult& result);
/// The pose's two parts, as `pose` otherwise: in the local frame, and where that frame lies in the map.
pose_estimate_t local_pose_message(const pose_estimate_t& pose, const StepResult& result,
                                   const std::string& local_frame);
pose_estimate_t correction_message(const pose_estimate_t& pose, const StepResult& result,
                                   const std::string& local_frame);
particles_t particles_message(Utime utime, const StepResult& result, const FastSlam& slam);
associations_t associations_message(const FeatureFrame& frame, const StepResult& result);

}  // namespace lcmslam

#pragma once
// Recordings of landmarks (MRCLAM, Victoria Park) as an .lcmlog that odometry and fastslam take.

#include <cstdint>
#include <string>

#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/runtime/publisher.hpp>

namespace lcmslam {

struct LandmarkLogCounts {
  std::int64_t frames = 0, features = 0, motions = 0, truths = 0, bytes = 0;
};

/// FEATURES, TWIST or ODOMETRY, and GROUND_TRUTH (for evaluation only), in order of message time. Throws
/// std::runtime_error naming the file.
LandmarkLogCounts write_landmark_log(const LandmarkRecording& recording, const std::string& file);

/// The same messages in the same order to a publisher.
void publish_landmarks(const LandmarkRecording& recording, Publisher& publisher);

}  // namespace lcmslam

#include <lcmslam/fastslam/association/expected_landmarks.hpp>

#include <algorithm>

#include <lcmslam/fastslam/association/visibility.hpp>

namespace lcmslam {
namespace {

/// Whether it was seen from about there the last time: what was seen from elsewhere may be hidden.
bool was_seen_from(const Eigen::Vector3d& camera, const VisibleLandmark& landmark,
                   const LandmarkRecord& record) {
  const Eigen::Vector3d then = landmark.mean + record.seen_at * record.seen_from;
  return (camera - then).norm() < std::max(0.5, 0.2 * record.seen_at);
}

}  // namespace

ExpectedLandmarks expected_landmarks(const std::vector<VisibleLandmark>& visible, const FeatureFrame& frame,
                                     const std::vector<FeaturePoint>& points,
                                     const Eigen::Isometry3d& T_world_robot, const LandmarkIndex& index,
                                     const FastSlamSettings& settings) {
  const Eigen::Vector3d camera = T_world_robot * frame.T_robot_camera.translation();
  const LandmarkVisibility visibility(frame, points, T_world_robot);
  ExpectedLandmarks expected;
  for (const VisibleLandmark& landmark : visible) {
    const LandmarkRecord& record = index.record(landmark.slot);
    if (record.observations < settings.minimum_observations || !was_seen_from(camera, landmark, record))
      continue;
    ++expected.landmarks;
    expected.hidden += visibility.is_hidden(landmark) ? 1 : 0;
    expected.free += visibility.is_free(landmark) ? 1 : 0;
  }
  return expected;
}

}  // namespace lcmslam

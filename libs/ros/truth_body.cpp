#include <lcmslam/ros/truth_body.hpp>

#include <cstdio>
#include <optional>

namespace lcmslam::ros {
namespace {

/// Nothing where tf does not lead there, or over joints: by one that moves a truth is none.
std::optional<Eigen::Isometry3d> still(const TransformTree& transforms, const std::string& from,
                                       const std::string& to) {
  if (to.empty()) return std::nullopt;
  const auto found = transforms.find(from, to);
  if (!found || !found->is_still()) return std::nullopt;
  return found->T_a_b;
}

std::string apart(const Eigen::Isometry3d& T) {
  char text[80];
  std::snprintf(text, sizeof text, "%.3f m and %.1f degrees away", T.translation().norm(),
                rotation_angle(T) * 180 / M_PI);
  return text;
}

}  // namespace

TruthBody find_truth_body(const std::string& frame, const std::string& robot_frame,
                          const std::string& colour_frame, const TransformTree& transforms) {
  TruthBody truth;
  if (frame.empty()) {
    truth.note = "true poses do not say whose they are: taken as the robot's";
    return truth;
  }
  if (frame == robot_frame) return truth;
  if (frame == colour_frame) {
    truth.body = "camera";
    truth.note = "true poses are the colour camera's";
    return truth;
  }
  if (const auto T = still(transforms, frame, robot_frame)) {
    truth.T_told_body = *T;
    truth.note = "true poses are of " + frame + ": brought to " + robot_frame + ", by tf " + apart(*T);
    return truth;
  }
  if (const auto T = still(transforms, frame, colour_frame)) {
    truth.body = "camera";
    truth.T_told_body = *T;
    truth.note = "true poses are of " + frame + ": brought to the colour camera, by tf " + apart(*T);
    return truth;
  }
  truth.note =
      "true poses are of " + frame + ", and where that sits on the robot nobody says: taken as the robot's";
  return truth;
}

}  // namespace lcmslam::ros

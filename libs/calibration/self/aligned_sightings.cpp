#include <lcmslam/calibration/self/aligned_sightings.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/calibration/self/depth_patch.hpp>
#include <lcmslam/calibration/self/landmark_tracks.hpp>

namespace lcmslam {
namespace {

constexpr int patch_radius = 9;  // pixels of the patch, from its middle

/// n with n p = 1 for the points p of the surface there, in the colour camera: as depth tells it, or facing
/// the camera where depth does not look. Nothing at an edge: what lies behind it moves otherwise.
std::optional<Eigen::Vector3d> surface_around(const Eigen::Vector3d& point, const ObservedKeyframe& keyframe,
                                              const RgbdCalibration& head) {
  const Eigen::Vector3d facing(0, 0, 1 / point.z());
  const CameraModel& d = head.depth;
  const auto pixel = d.project(head.T_colour_depth.inverse() * point);
  if (keyframe.inverse_depth.empty() || !pixel) return facing;
  const int rim = static_cast<int>(std::ceil(0.02 * d.fx));  // of what the smallest patch needs
  const cv::Point at(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
  const cv::Rect inside(rim, rim, d.width - 2 * rim, d.height - 2 * rim);
  if (!inside.contains(at) || !(keyframe.inverse_depth.at<float>(at) > 0)) return facing;
  const auto patch = depth_patch(keyframe.inverse_depth, *pixel, d, head.depth_noise);
  if (!patch) return std::nullopt;
  Eigen::Vector3d n(patch->along_u * d.fx, patch->along_v * d.fy, 0);
  n.z() = patch->inverse - n.dot(d.ray({patch->u, patch->v}));
  n = head.T_colour_depth.linear() * n;
  const double at_point = n.dot(point);  // the landmark lies on it, but for noise and what is to be found
  return at_point > 0 ? Eigen::Vector3d(n / at_point) : facing;
}

/// How offsets from a pixel become pixels of another keyframe: by central differences.
std::optional<PatchWarp> warp_of(const Eigen::Vector2d& at, const Eigen::Vector3d& surface,
                                 const Eigen::Isometry3d& T_to_from, const CameraModel& camera) {
  constexpr double h = 6;  // pixels
  Eigen::Vector2d m[3][3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d ray = camera.ray(at + h * Eigen::Vector2d(i - 1, k - 1));
      const double inverse = surface.dot(ray);
      if (!(inverse > 0)) return std::nullopt;
      const auto pixel = camera.project(T_to_from * Eigen::Vector3d(ray / inverse));
      if (!pixel) return std::nullopt;
      m[i][k] = *pixel;
    }
  PatchWarp warp;
  warp.t = m[1][1];
  warp.A << (m[2][1] - m[0][1]) / (2 * h), (m[1][2] - m[1][0]) / (2 * h);
  warp.bend << (m[2][1] + m[0][1] - 2 * m[1][1]) / (2 * h * h),
      (m[2][2] - m[2][0] - m[0][2] + m[0][0]) / (4 * h * h), (m[1][2] + m[1][0] - 2 * m[1][1]) / (2 * h * h);
  return warp;
}

}  // namespace

void align_sightings(SightedLandmark& landmark, const std::vector<ObservedKeyframe>& keyframes,
                     const RgbdCalibration& head) {
  const std::size_t middle = landmark.sightings.size() / 2;
  const LandmarkSighting reference = landmark.sightings[middle];
  const auto r = static_cast<std::size_t>(reference.keyframe);
  const Eigen::Isometry3d T_reference_world = keyframes[r].T_world_camera.inverse();
  const double z = (T_reference_world * landmark.point).z();
  const auto surface = surface_around(z * head.colour.ray(reference.pixel), keyframes[r], head);
  if (!surface) {
    landmark.sightings.clear();
    return;
  }
  std::vector<LandmarkSighting> aligned;
  for (std::size_t i = 0; i < landmark.sightings.size(); ++i) {
    LandmarkSighting sighting = landmark.sightings[i];
    sighting.sigma = 1;
    const auto k = static_cast<std::size_t>(sighting.keyframe);
    if (i != middle) {
      auto start = warp_of(reference.pixel, *surface,
                           (T_reference_world * keyframes[k].T_world_camera).inverse(), head.colour);
      if (!start) continue;
      start->t = sighting.pixel;
      const auto found =
          align_patch(keyframes[r].grey, reference.pixel, patch_radius, keyframes[k].grey, *start);
      if (!found) continue;
      sighting.pixel = found->t;
    }
    aligned.push_back(sighting);
  }
  landmark.sightings = std::move(aligned);
}

void align_sightings(SceneObservations& scene, const RgbdCalibration& head) {
  auto& landmarks = scene.landmarks;
  for (SightedLandmark& landmark : landmarks) align_sightings(landmark, scene.keyframes, head);
  landmarks.erase(std::remove_if(landmarks.begin(), landmarks.end(),
                                 [](const auto& landmark) {
                                   return landmark.sightings.size() < LandmarkTracks::fewest_sightings;
                                 }),
                  landmarks.end());
}

}  // namespace lcmslam

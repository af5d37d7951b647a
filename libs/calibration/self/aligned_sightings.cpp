#include <lcmslam/calibration/self/aligned_sightings.hpp>

namespace lcmslam {
namespace {

constexpr int patch_radius = 9;  // pixels of the patch, from its middle

/// How offsets from a pixel become pixels of another keyframe, as if the surface faced the first camera.
std::optional<Affine> facing_warp(const Eigen::Vector2d& at, double depth, const Eigen::Isometry3d& T_to_from,
                                  const CameraModel& camera) {
  constexpr double step = 4;  // pixels
  const auto lands = [&](const Eigen::Vector2d& pixel) {
    return camera.project(T_to_from * Eigen::Vector3d(depth * camera.ray(pixel)));
  };
  const auto middle = lands(at), right = lands(at + Eigen::Vector2d(step, 0)),
             below = lands(at + Eigen::Vector2d(0, step));
  if (!middle || !right || !below) return std::nullopt;
  Affine warp;
  warp.A.col(0) = (*right - *middle) / step;
  warp.A.col(1) = (*below - *middle) / step;
  return warp;
}

}  // namespace

void align_sightings(SightedLandmark& landmark, const std::vector<ObservedKeyframe>& keyframes,
                     const std::vector<cv::Mat>& greys, const CameraModel& camera) {
  const std::size_t middle = landmark.sightings.size() / 2;
  const LandmarkSighting reference = landmark.sightings[middle];
  const auto r = static_cast<std::size_t>(reference.keyframe);
  const Eigen::Isometry3d T_reference_world = keyframes[r].T_world_camera.inverse();
  const double depth = (T_reference_world * landmark.point).z();
  std::vector<LandmarkSighting> aligned;
  for (std::size_t i = 0; i < landmark.sightings.size(); ++i) {
    LandmarkSighting sighting = landmark.sightings[i];
    sighting.sigma = 1;
    const auto k = static_cast<std::size_t>(sighting.keyframe);
    if (i != middle) {
      auto start = facing_warp(reference.pixel, depth,
                               (T_reference_world * keyframes[k].T_world_camera).inverse(), camera);
      if (!start) continue;
      start->t = sighting.pixel;
      const auto found = align_patch(greys[r], reference.pixel, patch_radius, greys[k], *start);
      if (!found) continue;
      sighting.pixel = found->t;
    }
    aligned.push_back(sighting);
  }
  landmark.sightings = std::move(aligned);
}

}  // namespace lcmslam

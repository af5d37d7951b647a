#include <lcmslam/rendering/picture_points.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/rendering/point_spacing.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t sample = 20'000;                      // points that the extent is taken from
constexpr std::size_t path_sample = 100, path_weight = 60;  // few points of a path, but none is an outlier
constexpr double grazing = -0.15;  // cosine: walls seen edge-on from above stay, their normals are noisy

/// Height above which points without normal hide the room: over the robot's head when its path is
/// known, else under the ceiling, which is a level with many points in the upper third.
double automatic_cut(const PictureRequest& request) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const PicturePath& path : request.paths)
    for (const Eigen::Vector3d& point : path.points)
      if (point.allFinite()) highest = std::max(highest, point.z());
  constexpr double head_room = 1.5;  // m; a path may be that of the robot's base or of its camera
  constexpr double under = 0.15;     // m below the ceiling's level

  std::vector<double> heights;
  const std::size_t step = request.cloud->size() / sample + 1;
  for (std::size_t i = 0; i < request.cloud->size(); i += step)
    if (request.cloud->points[i].allFinite()) heights.push_back(request.cloud->points[i].z());
  const double low = quantile(heights, 0.01), high = quantile(heights, 0.995);
  constexpr int bins = 60;
  std::vector<std::size_t> counts(bins, 0);
  for (const double height : heights) {
    const double bin = (height - low) / std::max(high - low, 1e-6) * bins;
    if (bin >= 0) ++counts[static_cast<std::size_t>(std::min(bin, bins - 1.0))];
  }
  const auto upper = counts.begin() + bins * 2 / 3;
  const auto densest = std::max_element(upper, counts.end());
  const bool has_ceiling = *densest > heights.size() / 20;
  const double ceiling = low + (high - low) * static_cast<double>(densest - counts.begin()) / bins - under;
  if (has_ceiling && ceiling > highest - head_room) return ceiling;
  return std::isfinite(highest) ? highest + head_room : std::numeric_limits<double>::infinity();
}

}  // namespace

bool has_normal(const ColouredCloud& cloud, std::size_t i) {
  return cloud.normals.size() == cloud.size() && cloud.normals[i].allFinite() &&
         cloud.normals[i].squaredNorm() > 0;
}

PicturePoints::PicturePoints(const PictureRequest& request) : request_(request) {
  if (request.landmarks) nothing_ = request.landmarks->empty();
  for (const PicturePath& path : request.paths) nothing_ = nothing_ && path.points.empty();
  if (!request.cloud || request.cloud->size() == 0) return;
  const double automatic = request.cut_height ? *request.cut_height : automatic_cut(request);
  for (std::size_t i = 0; i < request.cloud->size(); ++i) {
    const Eigen::Vector3f& point = request.cloud->points[i];
    if (!point.allFinite()) continue;
    const bool normal = has_normal(*request.cloud, i);
    if ((request.cut_height || !normal) && point.z() > automatic) continue;
    candidates_.push_back(i);
    if (!normal) ++without_normal_;
  }
  nothing_ = nothing_ && candidates_.empty();
}

double PicturePoints::nearest_depth(const ViewCamera& camera) const {
  const bool few = without_normal_ * 2 < candidates_.size();
  if (camera.orthographic || request_.T_world_viewer || few) return 0;
  std::vector<double> depths;
  for (std::size_t k = 0; k < candidates_.size(); k += candidates_.size() / sample + 1)
    depths.push_back(camera.project(request_.cloud->points[candidates_[k]].cast<double>()).z());
  const double low = quantile(depths, 0.005), high = quantile(depths, 0.995);
  constexpr double share = 0.12;  // of the depth: the near wall and what stands at it
  return low + share * (high - low);
}

bool PicturePoints::shown(const ColouredCloud& cloud, std::size_t i, const ViewCamera& camera,
                          double nearest) const {
  const Eigen::Vector3d point = cloud.points[i].cast<double>();
  if (has_normal(cloud, i)) {
    const double cosine = cloud.normals[i].cast<double>().dot(camera.towards_viewer(point));
    return cosine > (camera.orthographic ? grazing : 0);
  }
  return camera.orthographic || camera.project(point).z() > nearest - 1e-6;
}

std::vector<Eigen::Vector3d> PicturePoints::extent(const ViewCamera* camera) const {
  std::vector<Eigen::Vector3d> points;
  const double nearest = camera ? nearest_depth(*camera) : 0;
  for (std::size_t k = 0; k < candidates_.size(); k += candidates_.size() / sample + 1)
    if (!camera || shown(*request_.cloud, candidates_[k], *camera, nearest))
      points.emplace_back(request_.cloud->points[candidates_[k]].cast<double>());
  if (request_.landmarks)
    for (const Landmark& landmark : *request_.landmarks)
      if (landmark.mean.allFinite()) points.push_back(landmark.mean);
  for (const PicturePath& path : request_.paths)
    for (std::size_t i = 0; i < path.points.size(); i += path.points.size() / path_sample + 1)
      if (path.points[i].allFinite()) points.insert(points.end(), path_weight, path.points[i]);
  return points;
}

void PicturePoints::add(const ColouredCloud& cloud, const std::vector<std::size_t>& candidates,
                        const ViewCamera& camera, bool paint, std::vector<SplatPoint>& splats) const {
  constexpr double sparsest = 0.025;  // m; gaps that are wider stay open
  std::vector<Eigen::Vector3f> places;
  const double nearest = nearest_depth(camera);
  const std::size_t first = splats.size();
  for (const std::size_t i : candidates) {
    if (!shown(cloud, i, camera, nearest)) continue;
    places.push_back(cloud.points[i]);
    splats.push_back({places.back().cast<double>(), cloud.colours[i], 0, paint});
  }
  const std::vector<float> spacing =
      point_spacing(places, request_.resolution, std::max(sparsest, request_.resolution));
  for (std::size_t i = 0; i < spacing.size(); ++i) splats[first + i].spacing = spacing[i];
}

std::vector<SplatPoint> PicturePoints::visible(const ViewCamera& camera) const {
  std::vector<SplatPoint> splats;
  if (!request_.cloud) return splats;
  add(*request_.cloud, candidates_, camera, false, splats);
  if (!request_.paint) return splats;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < request_.paint->size(); ++i)
    if (request_.paint->points[i].allFinite()) all.push_back(i);
  add(*request_.paint, all, camera, true, splats);
  return splats;
}

}  // namespace lcmslam

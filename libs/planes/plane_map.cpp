#include <lcmslam/planes/plane_map.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int pixel_step = 2;  // rows and columns of labelled pixels that tell outlines
constexpr int least_hits = 3;  // of a cell of the outline
constexpr double sigmas = 3;

Eigen::Isometry3d frame_of(const PlaneFit& fit) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << fit.axis, fit.plane.normal.cross(fit.axis), fit.plane.normal;
  T.translation() = fit.centre;
  return T;
}

double height_of(const PlanePatch& patch, const Eigen::Vector3d& up) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : patch.outline) sum += p;
  return up.dot(sum) / static_cast<double>(patch.outline.size());
}

/// Which way the plane looks, before anything is known of the others.
PlaneLabel first_label(const PlanePatch& patch, const Eigen::Vector3d& up, const PlaneMapSettings& settings) {
  const double level = patch.fit.plane.normal.dot(up);
  if (patch.area < settings.min_area) return PlaneLabel::other;
  if (level > std::cos(settings.up_angle)) return PlaneLabel::table_top;
  if (level < -std::cos(settings.up_angle)) return PlaneLabel::ceiling;
  if (std::abs(level) < std::sin(settings.up_angle)) return PlaneLabel::wall;
  return PlaneLabel::other;
}

}  // namespace

PlaneMap::PlaneMap(const PlaneMapSettings& settings) : settings_(settings) {
  check(settings_, "plane_map");
}

void PlaneMap::insert(const FramePlanes& found, const cv::Mat& depth, const CellMoments& cells,
                      const Eigen::Isometry3d& T_map_depth) {
  std::vector<std::size_t> plane_of;  // number in planes_ of each plane of the frame
  for (const FramePlane& seen : found.planes) {
    const PlaneMoments moments = seen.moments.moved(T_map_depth);
    const PlaneFit fit = moments.fit(T_map_depth.translation());
    Plane* plane = partner(fit);
    if (plane == nullptr) {
      planes_.push_back({{}, fit, frame_of(fit), T_map_depth.translation(), PlaneGrid(settings_.grid), 0});
      plane = &planes_.back();
    }
    plane->moments.add(moments);
    plane->fit = plane->moments.fit(plane->seen_from);
    ++plane->looks;
    plane_of.push_back(static_cast<std::size_t>(plane - planes_.data()));
  }
  std::vector<std::vector<Eigen::Vector2d>> places(planes_.size());
  for (int v = 0; v < depth.rows; v += pixel_step)
    for (int u = 0; u < depth.cols; u += pixel_step) {
      const std::uint8_t label = found.labels.at<std::uint8_t>(v, u);
      if (label == 0) continue;
      const std::size_t k = plane_of[label - 1u];
      const Eigen::Vector3d point =
          T_map_depth *
          cells.point(v, u, 0.001f * static_cast<float>(depth.at<std::uint16_t>(v, u))).cast<double>();
      const Eigen::Isometry3d& T = planes_[k].T_map_plane;
      places[k].push_back((T.linear().transpose() * (point - T.translation())).head<2>());
    }
  for (std::size_t k = 0; k < planes_.size(); ++k) planes_[k].grid.add(places[k]);
}

/// The nearest plane that may be the same; null when there is none.
PlaneMap::Plane* PlaneMap::partner(const PlaneFit& fit) {
  Plane* best = nullptr;
  double nearest = std::numeric_limits<double>::infinity();
  for (Plane& plane : planes_) {
    const double tilt = sigmas * std::sqrt(fit.variance.head<2>().maxCoeff());
    const double spread = sigmas * std::sqrt(fit.variance[2] + plane.fit.variance[2]);
    const double off = std::abs(plane.fit.plane.distance(fit.centre));
    if (plane.fit.plane.normal.dot(fit.plane.normal) < std::cos(settings_.max_angle + tilt)) continue;
    if (off > settings_.max_distance + spread || off >= nearest) continue;
    nearest = off;
    best = &plane;
  }
  return best;
}

std::vector<PlanePatch> PlaneMap::patches(const Eigen::Vector3d& up) const {
  std::vector<PlanePatch> patches;
  for (const Plane& plane : planes_) {
    if (plane.looks < settings_.min_looks) continue;
    for (const PlaneGrid::Part& part : plane.grid.parts(least_hits)) {
      PlanePatch patch;
      patch.fit = plane.fit;
      patch.area = part.area;
      patch.looks = plane.looks;
      for (const Eigen::Vector2d& p : part.outline) {
        // The grid stays where it began; its points are brought into the plane as it is known now.
        const Eigen::Vector3d point = plane.T_map_plane * Eigen::Vector3d(p.x(), p.y(), 0);
        patch.outline.emplace_back(point - plane.fit.plane.distance(point) * plane.fit.plane.normal);
      }
      patch.label = first_label(patch, up, settings_);
      if (patch.area >= settings_.min_area) patches.push_back(std::move(patch));
    }
  }
  std::optional<double> floor;  // m
  for (const PlanePatch& patch : patches)
    if (patch.label == PlaneLabel::table_top)
      floor = std::min(floor.value_or(height_of(patch, up)), height_of(patch, up));
  for (PlanePatch& patch : patches)
    if (patch.label == PlaneLabel::table_top && height_of(patch, up) < *floor + settings_.table_height)
      patch.label = PlaneLabel::floor;
  return patches;
}

std::size_t PlaneMap::memory_bytes() const {
  std::size_t bytes = planes_.capacity() * sizeof(Plane);
  for (const Plane& plane : planes_) bytes += plane.grid.memory_bytes();
  return bytes;
}

}  // namespace lcmslam

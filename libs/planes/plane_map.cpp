#include <lcmslam/planes/plane_map.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <lcmslam/planes/plane_view.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int pixel_step = 4;  // rows and columns of labelled pixels that tell how far a plane reaches
constexpr double sigmas = 3;
constexpr double most_tilt = 0.25;  // rad, that may be: who knows less of a plane can say where none begins
/// What a depth camera errs by alike over a whole surface, no number of pixels and looks takes away: shares
/// of a depth's variance. A mean of n points is as sure as 1 / n + common; their slope errs by less.
constexpr double common = 0.15, common_slope = 0.01;
constexpr auto none = std::numeric_limits<std::size_t>::max();

/// By how much the plane may be tilted, rad.
double tilt_of(const PlaneFit& fit) {
  return sigmas * std::sqrt(fit.variance.head<2>().maxCoeff());
}

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

void PlaneMap::insert(const FramePlanes& found, const CellMoments& cells,
                      const Eigen::Isometry3d& T_map_depth) {
  std::vector<std::size_t> plane_of;  // number in planes_ of each plane of the frame
  for (const FramePlane& seen : found.planes) {
    const PlaneMoments moments = seen.moments.moved(T_map_depth);
    const PlaneFit fit = moments.fit(T_map_depth.translation());
    Plane* plane = partner(fit);
    if (plane == nullptr && tilt_of(fit) > most_tilt) {
      plane_of.push_back(none);
      continue;
    }
    if (plane == nullptr) {
      planes_.push_back({{},
                         fit,
                         frame_of(fit),
                         T_map_depth.translation(),
                         PlaneGrid(settings_.grid, settings_.min_looks),
                         0});
      plane = &planes_.back();
    }
    plane->moments.add(moments);
    plane->fit = plane->moments.fit(plane->seen_from);
    ++plane->looks;
    plane_of.push_back(static_cast<std::size_t>(plane - planes_.data()));
  }
  look(found.labels, plane_of, cells, T_map_depth);
  make_room(T_map_depth.translation());
}

/// Counts the cells of the planes' grids that the frame shows. Each is looked up in the image: so planes that
/// are far or slanted, whose pixels lie farther apart than cells, have no gaps.
void PlaneMap::look(const cv::Mat& labels, const std::vector<std::size_t>& plane_of, const CellMoments& cells,
                    const Eigen::Isometry3d& T_map_depth) {
  std::map<std::size_t, PlaneView> views;  // of each plane that the frame shows
  std::vector<PlaneView*> view_of;         // of each label
  view_of.reserve(plane_of.size());
  for (const std::size_t k : plane_of)
    view_of.push_back(
        k == none
            ? nullptr
            : &views.try_emplace(k, planes_[k].T_map_plane, planes_[k].fit.plane, T_map_depth).first->second);
  const CameraModel& camera = cells.camera();
  for (int v = 0; v < labels.rows; v += pixel_step)
    for (int u = 0; u < labels.cols; u += pixel_step)
      if (const std::uint8_t label = labels.at<std::uint8_t>(v, u);
          label != 0 && view_of[label - 1u] != nullptr)
        view_of[label - 1u]->reach_to(cells.point(v, u, 1).cast<double>(), pixel_step / camera.fx);
  for (const auto& [k, view] : views)
    planes_[k].grid.look(view.box(), [&, plane = k, &seen = view](const Eigen::Vector2d& place) {
      const std::optional<Eigen::Vector2d> pixel = camera.project(seen.point(place));
      if (!pixel || !camera.contains(*pixel)) return false;
      const std::uint8_t label =
          labels.at<std::uint8_t>(static_cast<int>(pixel->y() + 0.5), static_cast<int>(pixel->x() + 0.5));
      return label != 0 && plane_of[label - 1u] == plane;
    });
}

/// The nearest plane that may be the same; null when there is none.
PlaneMap::Plane* PlaneMap::partner(const PlaneFit& fit) {
  Plane* best = nullptr;
  double nearest = std::numeric_limits<double>::infinity();
  for (Plane& plane : planes_) {
    const double tilt = std::min(tilt_of(fit), most_tilt);
    const double spread = sigmas * std::sqrt(fit.variance[2] + plane.fit.variance[2]);
    const double off = std::abs(plane.fit.plane.distance(fit.centre));
    if (plane.fit.plane.normal.dot(fit.plane.normal) < std::cos(settings_.max_angle + tilt)) continue;
    if (off > settings_.max_distance + spread || off >= nearest) continue;
    if ((plane.T_map_plane.translation() - fit.centre).norm() > settings_.max_reach) continue;
    nearest = off;
    best = &plane;
  }
  return best;
}

/// The planes farthest from the place give way, a tenth of the memory at a time.
void PlaneMap::make_room(const Eigen::Vector3d& place) {
  const auto most = static_cast<std::size_t>(1e6 * settings_.memory);
  std::size_t bytes = memory_bytes();
  if (bytes <= most) return;
  std::vector<std::pair<double, std::size_t>> by_distance;  // m, number in planes_
  for (std::size_t k = 0; k < planes_.size(); ++k)
    by_distance.emplace_back((planes_[k].fit.centre - place).norm(), k);
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<bool> stays(planes_.size(), true);
  while (bytes > most - most / 10 && by_distance.size() > 1) {
    const std::size_t farthest = by_distance.back().second;
    by_distance.pop_back();
    stays[farthest] = false;
    bytes -= planes_[farthest].grid.memory_bytes() + sizeof(Plane);
  }
  std::vector<Plane> near;
  for (std::size_t k = 0; k < planes_.size(); ++k)
    if (stays[k]) near.push_back(std::move(planes_[k]));
  planes_ = std::move(near);
}

std::vector<PlanePatch> PlaneMap::patches(const Eigen::Vector3d& up) const {
  std::vector<PlanePatch> patches;
  for (const Plane& plane : planes_) {
    if (plane.looks < settings_.min_looks) continue;
    for (const PlaneGrid::Part& part : plane.grid.parts()) {
      PlanePatch patch;
      patch.fit = plane.fit;
      const double points = plane.moments.points;
      patch.fit.variance.array() *= 1 + points * Eigen::Array3d(common_slope, common_slope, common);
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

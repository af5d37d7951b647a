#include <lcmslam/planes/frame_planes.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <lcmslam/planes/plane_rims.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int bins = 16;  // of normals, for each of two of their coordinates
const Eigen::Vector3d camera_centre = Eigen::Vector3d::Zero();

std::size_t direction(const Eigen::Vector3d& normal) {
  const auto bin = [](double c) { return std::clamp(static_cast<int>((c + 1) * 0.5 * bins), 0, bins - 1); };
  return static_cast<std::size_t>(bin(normal.x()) * bins + bin(normal.y()));
}

FramePlaneSettings checked_settings(const FramePlaneSettings& settings) {
  check(settings, "planes");
  return settings;
}

}  // namespace

FramePlaneFinder::FramePlaneFinder(const RgbdCalibration& calibration, const FramePlaneSettings& settings)
    : settings_(checked_settings(settings)),
      camera_(calibration.depth_registered ? calibration.colour : calibration.depth),
      cell_(std::max(2, camera_.width / settings_.cells_across)),
      moments_(calibration, cell_) {}

FramePlanes FramePlaneFinder::operator()(const cv::Mat& depth) {
  if (depth.type() != CV_16UC1 || depth.cols != camera_.width || depth.rows != camera_.height)
    throw std::invalid_argument("planes: the depth image is " + std::to_string(depth.cols) + "x" +
                                std::to_string(depth.rows) + ", by its calibration it must be " +
                                std::to_string(camera_.width) + "x" + std::to_string(camera_.height) +
                                " with 16 bits");
  fit_cells(depth);
  std::vector<Direction> directions = directions_of_cells();
  std::vector<std::vector<int>> regions;
  for (int seed = next_seed(directions); seed >= 0; seed = next_seed(directions)) {
    std::vector<int> region = grow(seed, static_cast<int>(regions.size()) + 1);
    for (const int i : region)
      --directions[direction(cells_[static_cast<std::size_t>(i)].fit.plane.normal)].free;
    regions.push_back(std::move(region));
  }
  regions = join_regions(std::move(regions));

  FramePlanes found;
  std::vector<std::uint8_t> plane_of_cell(cells_.size(), 0);
  for (const std::vector<int>& region : regions) {
    FramePlane plane;
    plane.moments = sum_of(region);
    plane.fit = plane.moments.fit(camera_centre);
    found.planes.push_back(plane);
    for (const int i : region)
      plane_of_cell[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(found.planes.size());
  }
  follow_rims(depth, moments_, cell_moments_, plane_of_cell, settings_, found);
  return found;
}

void FramePlaneFinder::fit_cells(const cv::Mat& depth) {
  cell_moments_ = moments_(depth);
  cells_.assign(cell_moments_.size(), {});
  const double least = settings_.least_valid * cell_ * cell_;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const PlaneMoments& moments = cell_moments_[i];
    if (moments.points < least) continue;
    Cell& cell = cells_[i];
    cell.sigma = moments_.sigma(moments.sum.z() / moments.weight);
    if (cell.sigma > settings_.max_sigma) continue;
    cell.fit = moments.fit(camera_centre);
    // Along the ray the noise is sigma; across a slanted plane it is less, but then its pixels lie farther
    // apart.
    cell.plane = cell.fit.rms <= settings_.flatness * cell.sigma;
  }
}

PlaneMoments FramePlaneFinder::sum_of(const std::vector<int>& cells) const {
  PlaneMoments sum;
  for (const int i : cells) sum.add(cell_moments_[static_cast<std::size_t>(i)]);
  return sum;
}

/// The plane cells by where they look, the flattest last.
std::vector<FramePlaneFinder::Direction> FramePlaneFinder::directions_of_cells() const {
  std::vector<Direction> directions(bins * bins);
  for (std::size_t i = 0; i < cells_.size(); ++i)
    if (cells_[i].plane)
      directions[direction(cells_[i].fit.plane.normal)].cells.push_back(static_cast<int>(i));
  for (Direction& d : directions) {
    std::stable_sort(d.cells.begin(), d.cells.end(), [&](int a, int b) {
      return cells_[static_cast<std::size_t>(a)].fit.rms > cells_[static_cast<std::size_t>(b)].fit.rms;
    });
    d.free = static_cast<int>(d.cells.size());
  }
  return directions;
}

/// The flattest free cell of the direction that most free cells have; -1 when there is none.
int FramePlaneFinder::next_seed(std::vector<Direction>& directions) const {
  const auto fewer = [](const Direction& a, const Direction& b) { return a.free < b.free; };
  Direction& commonest = *std::max_element(directions.begin(), directions.end(), fewer);
  if (commonest.free < 1) return -1;
  while (cells_[static_cast<std::size_t>(commonest.cells.back())].region != 0) commonest.cells.pop_back();
  return commonest.cells.back();
}

/// Cells that touch the region and lie in its plane, which is fitted anew whenever the region has doubled.
std::vector<int> FramePlaneFinder::grow(int seed, int region) {
  const int columns = moments_.columns(), rows = moments_.rows();
  std::vector<int> members{seed};
  PlaneMoments moments = cell_moments_[static_cast<std::size_t>(seed)];
  PlaneFit fit = cells_[static_cast<std::size_t>(seed)].fit;
  std::size_t fitted = 1;
  cells_[static_cast<std::size_t>(seed)].region = region;
  for (std::size_t next = 0; next < members.size(); ++next) {
    const int column = members[next] % columns, row = members[next] / columns;
    const int neighbours[][2] = {{column - 1, row}, {column + 1, row}, {column, row - 1}, {column, row + 1}};
    for (const auto& [c, r] : neighbours) {
      if (c < 0 || r < 0 || c >= columns || r >= rows) continue;
      Cell& cell = cells_[static_cast<std::size_t>(r * columns + c)];
      if (!cell.plane || cell.region != 0 || !lies_in(fit.plane, r * columns + c)) continue;
      cell.region = region;
      members.push_back(r * columns + c);
      moments.add(cell_moments_[static_cast<std::size_t>(r * columns + c)]);
      if (members.size() < 2 * fitted) continue;
      fit = moments.fit(camera_centre);
      fitted = members.size();
    }
  }
  return members;
}

/// Whether a cell's points lie in a plane. Its normal says less: small and far cells are tilted by noise.
bool FramePlaneFinder::lies_in(const PlaneEquation& plane, int i) const {
  const Cell& cell = cells_[static_cast<std::size_t>(i)];
  const PlaneMoments& moments = cell_moments_[static_cast<std::size_t>(i)];
  return cell.fit.plane.normal.dot(plane.normal) > std::cos(settings_.max_angle) &&
         moments.rms_from(plane) <= settings_.flatness * cell.sigma;
}

/// Whether region b's centre lies in a's plane, and its normal too.
bool FramePlaneFinder::are_one(const PlaneFit& a, const PlaneFit& b) const {
  constexpr double share = 0.3;  // of the angle of cells: regions' normals are better known
  return a.plane.normal.dot(b.plane.normal) > std::cos(share * settings_.max_angle) &&
         std::abs(a.plane.distance(b.centre)) < settings_.max_distance_sigmas * moments_.sigma(b.centre.z());
}

/// What something in front cut in two is one again. The largest first, those that are too small left out.
std::vector<std::vector<int>> FramePlaneFinder::join_regions(std::vector<std::vector<int>> regions) const {
  constexpr std::size_t least = 2;  // cells: one alone knows its plane too badly
  const auto larger = [](const auto& a, const auto& b) { return a.size() > b.size(); };
  std::stable_sort(regions.begin(), regions.end(), larger);
  std::vector<std::vector<int>> joined;
  std::vector<PlaneMoments> sums;
  std::vector<PlaneFit> fits;
  for (const std::vector<int>& region : regions) {
    if (region.size() < least) break;
    const PlaneMoments moments = sum_of(region);
    const PlaneFit fit = moments.fit(camera_centre);
    std::size_t k = 0;
    while (k < joined.size() && !are_one(fits[k], fit)) ++k;
    if (k == joined.size()) {
      joined.emplace_back();
      sums.emplace_back();
      fits.emplace_back();
    }
    joined[k].insert(joined[k].end(), region.begin(), region.end());
    sums[k].add(moments);
    fits[k] = sums[k].fit(camera_centre);
  }
  std::stable_sort(joined.begin(), joined.end(), larger);
  const auto too_small = [&](const auto& region) {
    return region.size() < static_cast<std::size_t>(settings_.min_cells);
  };
  joined.erase(std::find_if(joined.begin(), joined.end(), too_small), joined.end());
  if (joined.size() > most_planes) joined.resize(most_planes);
  return joined;
}

}  // namespace lcmslam

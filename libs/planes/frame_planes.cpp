#include <lcmslam/planes/frame_planes.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int directions = 16;  // of the histogram of normals, for each of two of their coordinates
const Eigen::Vector3d camera_centre = Eigen::Vector3d::Zero();

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
  std::vector<int> histogram(directions * directions, 0);
  for (const Cell& cell : cells_)
    if (cell.plane) ++histogram[static_cast<std::size_t>(direction(cell.fit.plane.normal))];

  std::vector<std::vector<int>> regions;
  for (int seed = best_seed(histogram); seed >= 0; seed = best_seed(histogram)) {
    std::vector<int> region = grow(seed, static_cast<int>(regions.size()) + 1);
    for (const int i : region)
      --histogram[static_cast<std::size_t>(direction(cells_[static_cast<std::size_t>(i)].fit.plane.normal))];
    regions.push_back(std::move(region));
  }
  regions = join_regions(std::move(regions));

  FramePlanes found;
  for (const std::vector<int>& region : regions) {
    FramePlane plane;
    for (const int i : region) plane.moments.add(cells_[static_cast<std::size_t>(i)].moments);
    plane.fit = plane.moments.fit(camera_centre);
    found.planes.push_back(plane);
  }
  label_pixels(depth, regions, found);
  return found;
}

void FramePlaneFinder::fit_cells(const cv::Mat& depth) {
  const std::vector<PlaneMoments> all = moments_(depth);
  cells_.assign(all.size(), {});
  const double least = settings_.least_valid * cell_ * cell_;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].points < least) continue;
    Cell& cell = cells_[i];
    cell.moments = all[i];
    cell.fit = all[i].fit(camera_centre);
    // Along the ray the noise is sigma; across a slanted plane it is less, but then its pixels lie farther
    // apart.
    cell.plane = cell.fit.rms <= settings_.flatness * 0.5 * moments_.sigma(cell.fit.centre.z());
  }
}

int FramePlaneFinder::direction(const Eigen::Vector3d& normal) const {
  const auto bin = [](double c) {
    return std::clamp(static_cast<int>((c + 1) * 0.5 * directions), 0, directions - 1);
  };
  return bin(normal.x()) * directions + bin(normal.y());
}

/// The flattest free cell of the commonest direction; -1 when there is none.
int FramePlaneFinder::best_seed(const std::vector<int>& histogram) const {
  const auto top = std::max_element(histogram.begin(), histogram.end());
  if (*top < 1) return -1;
  const auto commonest = static_cast<int>(top - histogram.begin());
  int best = -1;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    if (!cell.plane || cell.region != 0 || direction(cell.fit.plane.normal) != commonest) continue;
    if (best < 0 || cell.fit.rms < cells_[static_cast<std::size_t>(best)].fit.rms) best = static_cast<int>(i);
  }
  return best;
}

/// Cells that touch the region and lie in its plane, which is fitted anew whenever the region has doubled.
std::vector<int> FramePlaneFinder::grow(int seed, int region) {
  const int columns = moments_.columns(), rows = moments_.rows();
  std::vector<int> members{seed};
  PlaneMoments moments = cells_[static_cast<std::size_t>(seed)].moments;
  PlaneFit fit = cells_[static_cast<std::size_t>(seed)].fit;
  std::size_t fitted = 1;
  cells_[static_cast<std::size_t>(seed)].region = region;
  for (std::size_t next = 0; next < members.size(); ++next) {
    const int column = members[next] % columns, row = members[next] / columns;
    const int neighbours[][2] = {{column - 1, row}, {column + 1, row}, {column, row - 1}, {column, row + 1}};
    for (const auto& [c, r] : neighbours) {
      if (c < 0 || r < 0 || c >= columns || r >= rows) continue;
      Cell& cell = cells_[static_cast<std::size_t>(r * columns + c)];
      if (!cell.plane || cell.region != 0 || !agree(fit, cell.fit)) continue;
      cell.region = region;
      members.push_back(r * columns + c);
      moments.add(cell.moments);
      if (members.size() < 2 * fitted) continue;
      fit = moments.fit(camera_centre);
      fitted = members.size();
    }
  }
  return members;
}

/// Whether b's centre lies in a's plane, and its normal too.
bool FramePlaneFinder::agree(const PlaneFit& a, const PlaneFit& b) const {
  const double gate = settings_.max_distance_sigmas * moments_.sigma(b.centre.z());
  return a.plane.normal.dot(b.plane.normal) > std::cos(settings_.max_angle) &&
         std::abs(a.plane.distance(b.centre)) < gate;
}

/// What something in front cut in two is one again. The largest first.
std::vector<std::vector<int>> FramePlaneFinder::join_regions(std::vector<std::vector<int>> regions) {
  const auto larger = [](const auto& a, const auto& b) { return a.size() > b.size(); };
  std::stable_sort(regions.begin(), regions.end(), larger);
  std::vector<std::vector<int>> joined;
  std::vector<PlaneMoments> sums;
  for (const std::vector<int>& region : regions) {
    if (region.size() < static_cast<std::size_t>(settings_.min_cells)) break;
    PlaneMoments moments;
    for (const int i : region) moments.add(cells_[static_cast<std::size_t>(i)].moments);
    const PlaneFit fit = moments.fit(camera_centre);
    std::size_t k = 0;
    while (k < joined.size()) {
      const PlaneFit other = sums[k].fit(camera_centre);
      if (agree(other, fit) && other.plane.normal.dot(fit.plane.normal) > std::cos(0.5 * settings_.max_angle))
        break;
      ++k;
    }
    if (k == joined.size()) {
      if (k == most_planes) break;
      joined.emplace_back();
      sums.emplace_back();
    }
    joined[k].insert(joined[k].end(), region.begin(), region.end());
    sums[k].add(moments);
  }
  return joined;
}

/// Plane cells as they are; in the cells around them each pixel that lies in the plane.
void FramePlaneFinder::label_pixels(const cv::Mat& depth, const std::vector<std::vector<int>>& regions,
                                    FramePlanes& found) const {
  const int columns = moments_.columns(), rows = moments_.rows(), cell = cell_;
  found.labels = cv::Mat(depth.size(), CV_8UC1, cv::Scalar(0));
  std::vector<std::uint8_t> label(cells_.size(), 0);
  for (std::size_t k = 0; k < regions.size(); ++k)
    for (const int i : regions[k]) label[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(k + 1);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const cv::Rect area(column * cell, row * cell, cell, cell);
      const std::uint8_t own = label[static_cast<std::size_t>(row * columns + column)];
      std::vector<std::uint8_t> near;  // planes that may reach into the cell
      for (int n = 0; n < 25 && own == 0; ++n) {
        const int c = column + n % 5 - 2, r = row + n / 5 - 2;
        if (c < 0 || r < 0 || c >= columns || r >= rows) continue;
        const std::uint8_t other = label[static_cast<std::size_t>(r * columns + c)];
        if (other != 0 && std::find(near.begin(), near.end(), other) == near.end()) near.push_back(other);
      }
      if (own == 0 && near.empty()) continue;
      for (int v = area.y; v < area.y + cell; ++v)
        for (int u = area.x; u < area.x + cell; ++u) {
          const int mm = depth.at<std::uint16_t>(v, u);
          if (mm == 0) continue;
          if (own != 0) {
            found.labels.at<std::uint8_t>(v, u) = own;
            continue;
          }
          const Eigen::Vector3d point = moments_.point(v, u, 0.001f * static_cast<float>(mm)).cast<double>();
          double best = settings_.max_distance_sigmas * moments_.sigma(point.z());
          for (const std::uint8_t k : near) {
            const double off = std::abs(found.planes[k - 1u].fit.plane.distance(point));
            if (off >= best) continue;
            best = off;
            found.labels.at<std::uint8_t>(v, u) = k;
          }
        }
    }
}

}  // namespace lcmslam

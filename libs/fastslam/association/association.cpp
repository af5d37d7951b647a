#include <lcmslam/fastslam/association/association.hpp>

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include <lcmslam/fastslam/association/image_grid.hpp>
#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>

namespace lcmslam {
namespace {

// m^2, rank of a bearing among points in the choice of observations.
constexpr double bearing_variance = 4e-4;

}  // namespace

void sort_by_slot(std::vector<LandmarkMatch>& matches) {
  std::sort(matches.begin(), matches.end(),
            [](const LandmarkMatch& a, const LandmarkMatch& b) { return a.slot < b.slot; });
}

std::vector<LandmarkMatch> match_known(const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                       const LandmarkIndex& index, const Eigen::Isometry3d& T_world_robot) {
  std::vector<std::pair<double, LandmarkMatch>> candidates;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const int slot = index.find(points[p].landmark_id);
    if (slot < 0) continue;
    const LandmarkGaussian landmark = *map.find(static_cast<std::size_t>(slot));
    candidates.push_back(
        {innovate(landmark, points[p].measurement, T_world_robot).distance2, {static_cast<int>(p), slot, 0}});
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second.slot, a.first, a.second.point) <
           std::tie(b.second.slot, b.first, b.second.point);
  });
  std::vector<LandmarkMatch> matches;
  for (const auto& [distance2, match] : candidates)
    if (matches.empty() || matches.back().slot != match.slot) matches.push_back(match);
  return matches;
}

std::vector<LandmarkMatch> select_informative(const std::vector<LandmarkMatch>& matches,
                                              const FeatureFrame& frame,
                                              const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                              const FastSlamSettings& s) {
  const auto wanted = static_cast<std::size_t>(s.maximum_observations);
  if (matches.size() <= wanted) return matches;
  const ImageGrid grid(frame);
  struct Candidate {
    double variance;
    LandmarkMatch match;
  };
  std::array<std::vector<Candidate>, ImageGrid::cell_count> cells;
  for (const LandmarkMatch& match : matches) {
    const FeaturePoint& point = points[static_cast<std::size_t>(match.point)];
    const Feature& f = frame.features[static_cast<std::size_t>(point.feature)];
    // A bearing measures nothing along the ray: it comes after points that are as good across it.
    const double variance = map.find(static_cast<std::size_t>(match.slot))->variance() +
                            (point.is_bearing() ? bearing_variance : point.measurement.covariance.trace());
    cells[grid.cell(f.x, f.y)].push_back({variance, match});
  }
  for (auto& cell : cells)
    std::sort(cell.begin(), cell.end(), [](const Candidate& a, const Candidate& b) {
      return std::tie(a.variance, a.match.slot) < std::tie(b.variance, b.match.slot);
    });
  std::vector<LandmarkMatch> selected;
  for (std::size_t round = 0; selected.size() < wanted; ++round)
    for (const auto& cell : cells)
      if (round < cell.size() && selected.size() < wanted) selected.push_back(cell[round].match);
  sort_by_slot(selected);
  return selected;
}

}  // namespace lcmslam

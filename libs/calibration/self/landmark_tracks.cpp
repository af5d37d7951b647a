#include <lcmslam/calibration/self/landmark_tracks.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {
namespace {

constexpr double ratio = 0.75;

/// Of the ideal image, px; nothing without depth.
bool lands_near(const Feature& from, const Feature& at, const Eigen::Isometry3d& T_at_from,
                const FeatureFrame& frame, double gate) {
  if (!from.point.allFinite()) return true;
  const Eigen::Vector3d p = T_at_from * from.point.cast<double>();
  if (!(p.z() > 0.1)) return false;
  const double x = frame.fx * p.x() / p.z() + frame.cx, y = frame.fy * p.y() / p.z() + frame.cy;
  return std::hypot(x - static_cast<double>(at.x), y - static_cast<double>(at.y)) < gate;
}

}  // namespace

LandmarkTracks::LandmarkTracks(const RgbdCalibration& calibration, double gate, std::uint64_t seed)
    : calibration_(calibration), gate_(gate), random_(seed, 1) {}

void LandmarkTracks::add(const FeatureFrame& features, const Eigen::Isometry3d& T_world_camera) {
  first_.push_back(nodes_.size());
  for (std::size_t i = 0; i < features.features.size(); ++i)
    nodes_.push_back({frames_.size(), i, nodes_.size(), {frames_.size()}});
  frames_.push_back(features);
  poses_.push_back(T_world_camera);
}

std::size_t LandmarkTracks::root(std::size_t node) const {
  while (nodes_[node].parent != node) node = nodes_[node].parent;
  return node;
}

// A landmark is seen once in an image: trees that share a keyframe are two.
void LandmarkTracks::join(std::size_t a, std::size_t b) {
  a = root(a), b = root(b);
  if (a == b) return;
  std::vector<std::size_t> all, shared;
  std::set_intersection(nodes_[a].keyframes.begin(), nodes_[a].keyframes.end(), nodes_[b].keyframes.begin(),
                        nodes_[b].keyframes.end(), std::back_inserter(shared));
  if (!shared.empty()) return;
  std::merge(nodes_[a].keyframes.begin(), nodes_[a].keyframes.end(), nodes_[b].keyframes.begin(),
             nodes_[b].keyframes.end(), std::back_inserter(all));
  nodes_[a].keyframes = std::move(all);
  nodes_[b].keyframes.clear();
  nodes_[b].parent = a;
}

void LandmarkTracks::match_last(std::size_t earlier) {
  const std::size_t last = frames_.size() - 1;
  const FeatureFrame &a = frames_[earlier], &b = frames_[last];
  MatchingSettings matching;
  matching.ratio = ratio;
  const std::vector<Match> matches = matcher_.match(a.features, b.features, matching);
  const RigidRansacResult motion = align_ransac(a, b, matches, {}, random_);
  if (!motion.success) return;
  for (const Match& match : matches) {
    const auto i = static_cast<std::size_t>(match.a), k = static_cast<std::size_t>(match.b);
    const Feature &f = a.features[i], &g = b.features[k];
    if (!f.point.allFinite() && !g.point.allFinite()) continue;
    if (lands_near(f, g, motion.T_a_b.inverse(), b, gate_) && lands_near(g, f, motion.T_a_b, a, gate_))
      join(first_[earlier] + i, first_[last] + k);
  }
}

std::vector<SightedLandmark> LandmarkTracks::landmarks(std::size_t most) const {
  std::vector<std::vector<std::size_t>> trees(nodes_.size());
  for (std::size_t n = 0; n < nodes_.size(); ++n)
    if (const std::size_t r = root(n); nodes_[r].keyframes.size() >= fewest_sightings) trees[r].push_back(n);
  trees.erase(std::remove_if(trees.begin(), trees.end(), [](const auto& tree) { return tree.empty(); }),
              trees.end());
  std::stable_sort(trees.begin(), trees.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });

  std::vector<SightedLandmark> landmarks;
  for (const auto& tree : trees) {
    if (landmarks.size() == most) break;
    SightedLandmark landmark;
    std::vector<double> coordinates[3];
    for (const std::size_t n : tree) {
      const FeatureFrame& frame = frames_[nodes_[n].keyframe];
      const Feature& f = frame.features[nodes_[n].feature];
      // The feature's place is the ideal image's: back to where it was seen.
      const Eigen::Vector3d ray((static_cast<double>(f.x) - frame.cx) / frame.fx,
                                (static_cast<double>(f.y) - frame.cy) / frame.fy, 1);
      const auto pixel = calibration_.colour.project(ray);
      if (!pixel) continue;
      landmark.sightings.push_back(
          {static_cast<int>(nodes_[n].keyframe), *pixel, pixel_sigma(f, frame) / frame.pixel_sigma});
      if (!f.point.allFinite()) continue;
      const Eigen::Vector3d p = poses_[nodes_[n].keyframe] * f.point.cast<double>();
      for (int i = 0; i < 3; ++i) coordinates[i].push_back(p(i));
    }
    if (coordinates[0].empty() || landmark.sightings.size() < fewest_sightings) continue;
    for (int i = 0; i < 3; ++i) {
      auto& c = coordinates[i];
      std::nth_element(c.begin(), c.begin() + static_cast<std::ptrdiff_t>(c.size() / 2), c.end());
      landmark.point(i) = c[c.size() / 2];
    }
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

}  // namespace lcmslam

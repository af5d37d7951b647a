#include <lcmslam/pose_graph/loop_finder.hpp>

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

#include <lcmslam/features/strongest_features.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int node_limit = 1 << 24;  // ids of a DescriptorIndex

Matrix6d squares(double translation, double rotation) {
  Matrix6d m = Matrix6d::Zero();
  m.diagonal().head<3>().setConstant(translation * translation);
  m.diagonal().tail<3>().setConstant(rotation * rotation);
  return m;
}

// Along a bare wall or floor a cloud fits anywhere, and stays where it was thought to be.
Matrix6d unmeasured(const RegistrationResult& result) {
  constexpr double sigma = 30;  // m, rad
  Matrix6d covariance = Matrix6d::Zero();
  for (const Vector6d& twist : result.degenerate) covariance += sigma * sigma * twist * twist.transpose();
  return covariance;
}

}  // namespace

RegistrationSettings LoopFinderSettings::registration_defaults() {
  RegistrationSettings s;
  s.selection = SelectionKind::uniform;
  s.selected_points = 1500;
  s.max_distance = 0.15;
  s.min_distance = 0.06;
  s.max_iterations = 15;
  return s;
}

std::size_t memory_bytes(const KeyframeView& view) {
  return sizeof view + memory_bytes(view.cloud) + view.features.features.capacity() * sizeof(Feature) +
         view.shows.capacity() * sizeof(int);
}

LoopFinder::LoopFinder(const LoopFinderSettings& settings) : settings_(settings) {
  check(settings, "loop finder");
}

void LoopFinder::add(std::shared_ptr<const KeyframeView> view) {
  refresh_index();
  const auto node = static_cast<std::size_t>(view->node);
  if (views_.size() <= node) views_.resize(node + 1);
  enter(view->features, view->node);
  views_[node] = std::move(view);
}

void LoopFinder::enter(const FeatureFrame& frame, int node) {
  const std::vector<Feature>& features = frame.features;
  for (const std::size_t i : strongest(features, settings_.indexed_features)) {
    const auto id = static_cast<int>(node_of_descriptor_.size());
    if (id >= node_limit) break;
    index_.insert(id, features[i].descriptor, features[i].laplacian);
    node_of_descriptor_.push_back(node);
  }
}

void LoopFinder::renumber(const std::vector<bool>& gone, const std::vector<int>& number) {
  std::vector<std::shared_ptr<const KeyframeView>> views;
  for (std::size_t old = 0; old < views_.size(); ++old) {
    if (gone[old] || !views_[old]) continue;
    const auto node = static_cast<std::size_t>(number[old]);
    if (views.size() <= node) views.resize(node + 1);
    views[node] = std::move(views_[old]);
  }
  views_ = std::move(views);
  stale_ = true;
}

void LoopFinder::refresh_index() {
  if (!std::exchange(stale_, false)) return;
  index_ = DescriptorIndex();
  node_of_descriptor_.clear();
  for (std::size_t node = 0; node < views_.size(); ++node)
    if (views_[node]) enter(views_[node]->features, static_cast<int>(node));
}

std::size_t LoopFinder::memory_bytes() const {
  std::size_t bytes = views_.capacity() * sizeof(views_[0]) + index_.memory_bytes() +
                      node_of_descriptor_.capacity() * sizeof(int);
  for (const auto& view : views_)
    if (view) bytes += lcmslam::memory_bytes(*view);
  return bytes;
}

const KeyframeView* LoopFinder::view(int node) const {
  return static_cast<std::size_t>(node) < views_.size() ? views_[static_cast<std::size_t>(node)].get()
                                                        : nullptr;
}

std::vector<int> LoopFinder::candidates(const FeatureFrame& features, const std::vector<int>& without) {
  refresh_index();
  if (index_.size() == 0) return {};
  std::vector<Feature> queries;
  for (const std::size_t i : strongest(features.features, settings_.indexed_features))
    queries.push_back(features.features[i]);
  const double limit = 127 * settings_.max_descriptor_distance;
  std::vector<int> votes(views_.size(), 0);
  for (const Neighbours& neighbours : search_.nearest(queries, index_)) {
    std::array<int, std::tuple_size_v<Neighbours>> voted_for{};  // a feature votes for a keyframe once
    auto end = voted_for.begin();
    for (const Neighbour& n : neighbours) {
      if (n.id < 0 || n.distance2 > limit * limit) continue;
      const int node = node_of_descriptor_[static_cast<std::size_t>(n.id)];
      if (std::find(voted_for.begin(), end, node) != end) continue;
      ++votes[static_cast<std::size_t>(node)];
      *end++ = node;
    }
  }
  for (const int node : without)
    if (static_cast<std::size_t>(node) < votes.size()) votes[static_cast<std::size_t>(node)] = 0;
  std::vector<int> nodes(votes.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  const auto votes_of = [&](int node) { return votes[static_cast<std::size_t>(node)]; };
  std::stable_sort(nodes.begin(), nodes.end(), [&](int a, int b) { return votes_of(a) > votes_of(b); });
  std::vector<int> best;
  for (const int node : nodes)
    if (votes_of(node) >= settings_.min_votes && static_cast<int>(best.size()) < settings_.candidates)
      best.push_back(node);
  return best;
}

std::optional<UncertainTransform> LoopFinder::verify(const KeyframeView& from, const KeyframeView& to,
                                                     const std::optional<Eigen::Isometry3d>& guess) {
  RigidRansacSettings ransac;
  ransac.min_inliers = settings_.min_inliers;
  Random random(1);
  const auto& matches = matcher_.match(from.features.features, to.features.features);
  const RigidRansacResult aligned = align_ransac(from.features, to.features, matches, ransac, random);
  if (!aligned.success && !guess) return std::nullopt;
  const Matrix6d noise_floor = squares(settings_.floor_translation, settings_.floor_rotation);

  Prior prior;
  if (aligned.success) {
    prior.T_target_source = aligned.T_a_b;
    prior.information = (aligned.covariance + noise_floor).inverse();
  }
  const KdTreeTarget target(from.cloud);
  const RegistrationResult result =
      register_cloud(to.cloud, target, aligned.success ? aligned.T_a_b : *guess, settings_.registration,
                     aligned.success ? &prior : nullptr, nullptr, to.noise_left);
  const bool fits = result.ok() && result.overlap >= settings_.min_overlap &&
                    result.inliers >= settings_.min_inlier_share * result.pairs;
  if (!fits) return std::nullopt;
  if (aligned.success &&
      distance_from_identity({aligned.T_a_b.inverse() * result.T_target_source,
                              aligned.covariance + noise_floor}) > settings_.max_disagreement)
    return std::nullopt;
  Matrix6d covariance = result.covariance + noise_floor;
  if (!aligned.success) covariance += unmeasured(result);
  return UncertainTransform{result.T_target_source, covariance};
}

}  // namespace lcmslam

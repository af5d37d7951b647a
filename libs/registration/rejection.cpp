#include <lcmslam/registration/rejection.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace lcmslam {
namespace {

template <class Bad>
void erase(std::vector<Pair>& pairs, const Bad& bad) {
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), bad), pairs.end());
}

}  // namespace

NormalAngleRejector::NormalAngleRejector(double max_angle) : min_cosine_(std::cos(max_angle)) {}

void NormalAngleRejector::reject(std::vector<Pair>& pairs, const Eigen::Isometry3d&) const {
  erase(pairs, [&](const Pair& p) { return p.moved_normal.dot(p.target_normal) < min_cosine_; });
}

void TrimmedRejector::reject(std::vector<Pair>& pairs, const Eigen::Isometry3d&) const {
  const auto kept = static_cast<std::size_t>(kept_fraction_ * static_cast<double>(pairs.size()));
  if (pairs.empty() || kept >= pairs.size()) return;
  std::vector<double> distances;
  distances.reserve(pairs.size());
  for (const Pair& p : pairs) distances.push_back(p.squared_distance());
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(kept), distances.end());
  const double limit = distances[kept];
  // Of those just at the limit the first: in a cloud that lies on itself they are all.
  auto at_limit = std::count(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(kept), limit);
  erase(pairs, [&](const Pair& p) {
    const double distance = p.squared_distance();
    return distance > limit || (distance == limit && at_limit-- <= 0);
  });
}

void MissingNormalRejector::reject(std::vector<Pair>& pairs, const Eigen::Isometry3d&) const {
  erase(pairs, [&](const Pair& p) {
    return !p.target_normal.allFinite() || (both_ && !p.moved_normal.allFinite());
  });
}

void MutualRejector::reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const {
  const Eigen::Isometry3f T_source_target = T_target_source.inverse().cast<float>();
  erase(pairs, [&](const Pair& p) {
    const Eigen::Vector3f back = T_source_target * p.target.cast<float>();
    return tree_.nearest(back, std::numeric_limits<float>::max()).index != static_cast<std::int32_t>(p.index);
  });
}

void BoundaryRejector::reject(std::vector<Pair>& pairs, const Eigen::Isometry3d&) const {
  erase(pairs, [](const Pair& p) { return p.boundary; });
}

void FrustumRejector::reject(std::vector<Pair>& pairs, const Eigen::Isometry3d&) const {
  erase(pairs, [&](const Pair& p) { return !frustum_.contains(T_camera_target_ * p.moved.cast<float>()); });
}

ColourOverlapRejector::ColourOverlapRejector(const Cloud& source, const SensorViews& views) {
  for (const Eigen::Vector3f& p : source.points)
    outside_.push_back(
        !may_overlap(views.T_camera_source * p.cast<double>(), *views.overlap, *views.source_camera));
}

void ColourOverlapRejector::reject(std::vector<Pair>& pairs, const Eigen::Isometry3d&) const {
  erase(pairs, [&](const Pair& p) { return outside_[p.index]; });
}

std::vector<std::unique_ptr<Rejector>> make_rejectors(const RegistrationSettings& settings,
                                                      const Cloud& source, const SensorViews* views) {
  std::vector<std::unique_ptr<Rejector>> chain;
  if (settings.metric != MetricKind::point_to_point)
    chain.push_back(std::make_unique<MissingNormalRejector>(settings.metric == MetricKind::plane_to_plane));
  if (settings.frustum) {
    if (!views || !views->frustum) throw std::invalid_argument("frustum rejection: no view of the target");
    chain.push_back(std::make_unique<FrustumRejector>(*views->frustum, views->T_camera_target));
  }
  if (settings.colour_overlap) {
    if (!views || !views->overlap || !views->source_camera)
      throw std::invalid_argument("colour overlap rejection: no images to compare");
    chain.push_back(std::make_unique<ColourOverlapRejector>(source, *views));
  }
  if (settings.boundary) chain.push_back(std::make_unique<BoundaryRejector>());
  if (settings.max_normal_angle < 3.14)
    chain.push_back(std::make_unique<NormalAngleRejector>(settings.max_normal_angle));
  if (settings.mutual) chain.push_back(std::make_unique<MutualRejector>(source));
  if (settings.trimmed_fraction < 1)
    chain.push_back(std::make_unique<TrimmedRejector>(settings.trimmed_fraction));
  return chain;
}

}  // namespace lcmslam

#include <lcmslam/features/guided_matching.hpp>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

namespace lcmslam {
namespace {

constexpr int none = std::numeric_limits<int>::max();
constexpr double cell = 32;  // pixels

void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(std::string("guided matching: ") + what);
}

void require_positive(double value, const char* name) {
  if (!(value > 0))
    throw std::invalid_argument(std::string("guided matching: ") + name + " is " + std::to_string(value) +
                                ", must be positive");
}

void check(const FeatureFrame& frame, const PredictedPose& pose, const GuidedSettings& s) {
  check_ratio(s.ratio);
  require_positive(s.chi_square, "chi_square");
  require_positive(s.max_gate, "max_gate");
  require_positive(s.max_distance, "max_distance");
  require_positive(frame.fx, "the frame's fx");
  require_positive(frame.fy, "the frame's fy");
  require_positive(frame.pixel_sigma, "the frame's pixel_sigma");
  require(frame.width > 0 && frame.height > 0, "the frame's image has no size");
  require(pose.T_world_camera.matrix().allFinite() && pose.covariance.allFinite(),
          "the predicted pose or its covariance is not finite");
  require(pose.covariance.diagonal().minCoeff() >= 0, "the pose's covariance has a negative variance");
}

// Whether the places differ by less than `near` (m) or their covariances explain (chi-square, 3 DoF, 99 %).
bool same_place(const MapPoint& a, const MapPoint& b, double near) {
  const Eigen::Vector3d difference = a.position - b.position;
  if (difference.squaredNorm() < near * near) return true;
  const Eigen::Matrix3d sum = a.covariance + b.covariance;
  return difference.dot(sum.inverse() * difference) < 11.345;
}

}  // namespace

bool GuidedResult::supported() const {
  const auto found = static_cast<double>(matches.size()), chance = static_cast<double>(by_chance);
  return found >= 10 && found - chance > 3 * std::sqrt(found + chance);
}

double GuidedMatcher::Gate::squared_innovation(double x, double y) const {
  const Eigen::Vector2d innovation(x - centre.x(), y - centre.y());
  return innovation.dot(information * innovation);
}

int GuidedMatcher::column(double x) const {
  return static_cast<int>(std::clamp(x / cell, 0., columns_ - 1.));
}

int GuidedMatcher::row(double y) const {
  return static_cast<int>(std::clamp(y / cell, 0., rows_ - 1.));
}

const GuidedResult& GuidedMatcher::match(const FeatureFrame& frame, const PredictedPose& pose,
                                         const std::vector<MapPoint>& landmarks, const DescriptorIndex& index,
                                         const GuidedSettings& settings) {
  check(frame, pose, settings);
  result_.matches.clear();
  result_.in_view = result_.too_vague = result_.by_chance = 0;
  result_.mean_squared_innovation = 0;
  open_gates(frame, pose, landmarks, index, settings);
  fill_grid(frame);

  compare(gates_.size() / 2, settings);
  find_nearest(frame.features.size(), settings.same_place);
  for (std::size_t f = 0; f < frame.features.size(); ++f) result_.by_chance += is_match(f, settings);

  compare(0, settings);
  find_nearest(frame.features.size(), settings.same_place);
  for (std::size_t f = 0; f < frame.features.size(); ++f) {
    if (!is_match(f, settings)) continue;
    const Gate& gate = gates_[static_cast<std::size_t>(of_feature_[f].partner)];
    result_.matches.push_back({static_cast<int>(f), gate.id, of_feature_[f].distance2});
    result_.mean_squared_innovation += gate.squared_innovation(frame.features[f].x, frame.features[f].y);
  }
  if (!result_.matches.empty())
    result_.mean_squared_innovation /= static_cast<double>(result_.matches.size());
  return result_;
}

void GuidedMatcher::open_gates(const FeatureFrame& frame, const PredictedPose& pose,
                               const std::vector<MapPoint>& landmarks, const DescriptorIndex& index,
                               const GuidedSettings& settings) {
  gates_.clear();
  for (const MapPoint& landmark : landmarks) {
    const Descriptor& descriptor = index.descriptor(landmark.id);
    const auto projection = project(landmark, pose.T_world_camera, frame);
    if (!projection) continue;
    const Eigen::Vector2d& pixel = projection->pixel;
    const double margin = settings.margin;
    if (pixel.x() < -margin || pixel.y() < -margin || pixel.x() > frame.width - 1 + margin ||
        pixel.y() > frame.height - 1 + margin)
      continue;
    const Eigen::Matrix2d S = innovation_covariance(*projection, landmark, pose, frame);
    const double half_width = std::sqrt(settings.chi_square * S(0, 0));
    const double half_height = std::sqrt(settings.chi_square * S(1, 1));
    if (!(S.allFinite() && S.determinant() > 0)) continue;
    ++result_.in_view;
    if (half_width > settings.max_gate || half_height > settings.max_gate) {
      ++result_.too_vague;
      continue;
    }
#ifdef __GNUC__
    __builtin_prefetch(descriptor.data());  // compared soon
#endif
    gates_.push_back({landmark.id, index.is_dark(landmark.id), &descriptor, &landmark, pixel, S.inverse(),
                      half_width, half_height});
  }
}

void GuidedMatcher::fill_grid(const FeatureFrame& frame) {
  columns_ = static_cast<int>(std::ceil(frame.width / cell));
  rows_ = static_cast<int>(std::ceil(frame.height / cell));
  const auto cell_of = [&](const Feature& f) {
    return static_cast<std::size_t>(row(f.y) * columns_ + column(f.x));
  };
  const auto usable = [](const Feature& f) { return std::isfinite(f.x) && std::isfinite(f.y); };
  cell_begin_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const Feature& f : frame.features)
    if (usable(f)) ++cell_begin_[cell_of(f)];
  int total = 0;  // each cell's end for now
  for (int& begin : cell_begin_) begin = total += begin;
  sought_.resize(static_cast<std::size_t>(total));
  wide_.resize(sought_.size());
  for (std::size_t f = frame.features.size(); f-- > 0;) {
    const Feature& feature = frame.features[f];
    if (!usable(feature)) continue;
    const auto place = static_cast<std::size_t>(--cell_begin_[cell_of(feature)]);
    sought_[place] = {feature.x, feature.y, static_cast<int>(f), feature.laplacian >= 0};
    wide_[place].assign(feature.descriptor);
  }
}

// Seeks each landmark in the gate `shift` places on, though never in its own when that is another's.
void GuidedMatcher::compare(std::size_t shift, const GuidedSettings& settings) {
  pairs_.clear();
  result_.candidates = 0;
  const double limit = settings.chi_square;
  // Whoever differs more is no match, and no rival of one: the ratio test passes beside it.
  const double largest = 127 * settings.max_distance / std::min(settings.ratio, 1.);
  const int relevant = static_cast<int>(std::min(1.01 * largest * largest, 1e9));
  for (std::size_t g = 0; g < gates_.size(); ++g) {
    const Gate& own = gates_[g];
    const Gate& gate = gates_[(g + shift) % gates_.size()];
    inside_.clear();
    const int last_row = row(gate.centre.y() + gate.half_height);
    const int last_column = column(gate.centre.x() + gate.half_width);
    for (int r = row(gate.centre.y() - gate.half_height); r <= last_row; ++r) {
      const auto first_cell =
          static_cast<std::size_t>(r * columns_ + column(gate.centre.x() - gate.half_width));
      const auto end_cell = static_cast<std::size_t>(r * columns_ + last_column + 1);
      // The cells of a row follow each other.
      for (int k = cell_begin_[first_cell]; k < cell_begin_[end_cell]; ++k) {
        const Sought& sought = sought_[static_cast<std::size_t>(k)];
        if (sought.dark != own.dark || !(gate.squared_innovation(sought.x, sought.y) < limit)) continue;
        if (shift != 0 && own.squared_innovation(sought.x, sought.y) < limit) continue;
        inside_.push_back(static_cast<std::size_t>(k));
      }
    }
    result_.candidates += static_cast<int>(inside_.size());
    measure(g, relevant);
  }
}

// The descriptors' distances of those inside; keeps what is `relevant`.
void GuidedMatcher::measure(std::size_t gate, int relevant) {
  if (inside_.empty()) return;
  const Descriptor& descriptor = *gates_[gate].descriptor;
  std::int32_t& norm2 = gates_[gate].norm2;
  if (norm2 < 0) norm2 = squared_norm(descriptor);
  for (std::size_t first = 0; first < inside_.size(); first += 4) {
    const std::size_t count = std::min<std::size_t>(4, inside_.size() - first);
    const WideDescriptor* group[4];
    for (std::size_t i = 0; i < 4; ++i) group[i] = &wide_[inside_[first + std::min(i, count - 1)]];
    Int4 distances;
    distances_(group, &descriptor, &norm2, 1, &distances);
    for (std::size_t i = 0; i < count; ++i)
      if (distances[i] <= relevant)
        pairs_.push_back({sought_[inside_[first + i]].feature, static_cast<int>(gate), distances[i]});
  }
}

// Of landmarks the nearest first, then the second among those that are not the nearest one's twin. Of equally
// near ones the first counts.
void GuidedMatcher::find_nearest(std::size_t features, double near) {
  of_feature_.assign(features, {none, none, -1});
  of_gate_.assign(gates_.size(), {none, none, -1});
  for (const Pair& pair : pairs_) {
    Nearest& landmark = of_feature_[static_cast<std::size_t>(pair.feature)];
    if (pair.distance2 < landmark.distance2) landmark = {pair.distance2, none, pair.gate};
    Nearest& feature = of_gate_[static_cast<std::size_t>(pair.gate)];
    if (std::tie(pair.distance2, pair.feature) < std::tie(feature.distance2, feature.partner))
      feature = {pair.distance2, feature.distance2, pair.feature};
    else
      feature.second2 = std::min(feature.second2, pair.distance2);
  }
  for (const Pair& pair : pairs_) {
    Nearest& landmark = of_feature_[static_cast<std::size_t>(pair.feature)];
    if (pair.gate == landmark.partner || pair.distance2 >= landmark.second2) continue;
    if (same_place(*gates_[static_cast<std::size_t>(pair.gate)].landmark,
                   *gates_[static_cast<std::size_t>(landmark.partner)].landmark, near))
      continue;
    landmark.second2 = pair.distance2;
  }
}

bool GuidedMatcher::is_match(std::size_t feature, const GuidedSettings& settings) const {
  const Nearest& landmark = of_feature_[feature];
  if (landmark.partner < 0) return false;
  const Nearest& back = of_gate_[static_cast<std::size_t>(landmark.partner)];
  const auto clear = [&](const Nearest& nearest) {
    return nearest.second2 == none || passes_ratio(nearest.distance2, nearest.second2, settings.ratio);
  };
  const double largest = 127 * settings.max_distance;  // in bytes
  return back.partner == static_cast<int>(feature) && landmark.distance2 <= largest * largest &&
         clear(landmark) && clear(back);
}

}  // namespace lcmslam

#include <lcmslam/cloud/kd_tree.hpp>

#include <algorithm>
#include <limits>

namespace lcmslam {
namespace {

constexpr std::int32_t leaf_size = 12;

bool before(const KdTree::Neighbour& a, const KdTree::Neighbour& b) {
  if (a.squared_distance != b.squared_distance) return a.squared_distance < b.squared_distance;
  return a.index < b.index;
}

}  // namespace

class KdTree::NearestSearch {
 public:
  explicit NearestSearch(float max_distance) { best_.squared_distance = max_distance * max_distance; }
  float bound() const { return best_.squared_distance; }
  void offer(const Neighbour& n) {
    if (best_.index < 0 ? n.squared_distance <= best_.squared_distance : before(n, best_)) best_ = n;
  }
  Neighbour best() const { return best_; }

 private:
  Neighbour best_;
};

class KdTree::ManySearch {
 public:
  ManySearch(std::size_t count, std::vector<Neighbour>& sorted) : count_(count), sorted_(sorted) {
    sorted_.clear();
    sorted_.reserve(count);
  }
  float bound() const {
    return sorted_.size() < count_ ? std::numeric_limits<float>::infinity() : sorted_.back().squared_distance;
  }
  // Few are asked for: moving them up is cheaper than a heap.
  void offer(const Neighbour& n) {
    if (sorted_.size() == count_) {
      if (!before(n, sorted_.back())) return;
      sorted_.pop_back();
    }
    sorted_.push_back(n);
    for (std::size_t i = sorted_.size() - 1; i > 0 && before(n, sorted_[i - 1]); --i)
      std::swap(sorted_[i], sorted_[i - 1]);
  }

 private:
  std::size_t count_;
  std::vector<Neighbour>& sorted_;
};

KdTree::KdTree(const std::vector<Eigen::Vector3f>& points) : points_(points) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].allFinite()) order_.push_back(static_cast<std::int32_t>(i));
  if (!order_.empty()) build(0, static_cast<std::int32_t>(order_.size()));
  points_.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) points_[i] = points[static_cast<std::size_t>(order_[i])];
}

// Splits the longest side at its median.
std::int32_t KdTree::build(std::int32_t begin, std::int32_t end) {
  const auto id = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back({0, -1, begin, end});
  if (end - begin <= leaf_size) return id;

  const auto point = [&](std::int32_t i) -> const Eigen::Vector3f& {
    return points_[static_cast<std::size_t>(i)];
  };
  Eigen::Vector3f low = point(order_[static_cast<std::size_t>(begin)]);
  Eigen::Vector3f high = low;
  for (std::int32_t i = begin; i < end; ++i) {
    low = low.cwiseMin(point(order_[static_cast<std::size_t>(i)]));
    high = high.cwiseMax(point(order_[static_cast<std::size_t>(i)]));
  }
  std::int32_t axis = 0;
  (high - low).maxCoeff(&axis);
  if (high(axis) == low(axis)) return id;  // all the same: a leaf of any size

  const std::int32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     return std::make_pair(point(a)(axis), a) < std::make_pair(point(b)(axis), b);
                   });
  const float split = point(order_[static_cast<std::size_t>(middle)])(axis);
  const std::int32_t left = build(begin, middle);
  const std::int32_t right = build(middle, end);
  nodes_[static_cast<std::size_t>(id)] = {split, axis, left, right};
  return id;
}

// `offset` holds, for each axis, the distance from the query to the cell (Arya and Mount 1993).
template <typename Search>
void KdTree::descend(std::int32_t id, const Eigen::Vector3f& query, Eigen::Vector3f offset,
                     Search& search) const {
  const Node& node = nodes_[static_cast<std::size_t>(id)];
  if (node.axis < 0) {
    for (auto i = static_cast<std::size_t>(node.left); i < static_cast<std::size_t>(node.right); ++i)
      if (const float d = (points_[i] - query).squaredNorm(); d <= search.bound())
        search.offer({order_[i], d});
    return;
  }
  const float side = query(node.axis) - node.split;
  descend(side < 0 ? node.left : node.right, query, offset, search);
  offset(node.axis) = side;
  if (offset.squaredNorm() <= search.bound())
    descend(side < 0 ? node.right : node.left, query, offset, search);
}

KdTree::Neighbour KdTree::nearest(const Eigen::Vector3f& query, float max_distance) const {
  if (order_.empty() || !query.allFinite() || !(max_distance >= 0)) return {};
  NearestSearch search(max_distance);
  descend(0, query, Eigen::Vector3f::Zero(), search);
  return search.best();
}

std::vector<KdTree::Neighbour> KdTree::nearest_few(const Eigen::Vector3f& query, std::size_t count) const {
  std::vector<Neighbour> found;
  nearest_few(query, count, found);
  return found;
}

void KdTree::nearest_few(const Eigen::Vector3f& query, std::size_t count,
                         std::vector<Neighbour>& found) const {
  found.clear();
  if (order_.empty() || !query.allFinite() || count == 0) return;
  ManySearch search(std::min(count, order_.size()), found);
  descend(0, query, Eigen::Vector3f::Zero(), search);
}

}  // namespace lcmslam

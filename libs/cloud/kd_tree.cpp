#include <lcmslam/cloud/kd_tree.hpp>

#include <flann/algorithms/kdtree_single_index.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace lcmslam {
namespace {

using Neighbour = KdTree::Neighbour;

constexpr int leaf_size = 12;

bool before(const Neighbour& a, const Neighbour& b) {
  if (a.squared_distance != b.squared_distance) return a.squared_distance < b.squared_distance;
  return a.index < b.index;
}

/// FLANN asks for points nearer than this: a little more than the worst that is kept, because equals with a
/// lower index are wanted too, and because it rounds the distances of its cells.
float bound_above(float squared_distance) {
  return squared_distance * 1.00001F + 1e-12F;
}

/// Squared length of the difference, summed in the order of Eigen's squaredNorm().
struct SquaredDistance {
  using is_kdtree_distance = bool;
  using ElementType = float;
  using ResultType = float;
  float operator()(const float* a, const float* b, std::size_t, float = -1) const {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + (y * y + z * z);
  }
  float accum_dist(float a, float b, int) const { return (a - b) * (a - b); }
};

class NearestSearch : public flann::ResultSet<float> {
 public:
  explicit NearestSearch(float max_distance) { best_.squared_distance = max_distance * max_distance; }
  bool full() const override { return true; }
  float worstDist() const override { return bound_above(best_.squared_distance); }
  void addPoint(float squared_distance, std::size_t index) override {
    const Neighbour n{static_cast<std::int32_t>(index), squared_distance};
    if (best_.index < 0 ? n.squared_distance <= best_.squared_distance : before(n, best_)) best_ = n;
  }
  Neighbour best() const { return best_; }

 private:
  Neighbour best_;
};

class FewSearch : public flann::ResultSet<float> {
 public:
  FewSearch(std::size_t count, std::vector<Neighbour>& sorted) : count_(count), sorted_(sorted) {
    sorted_.reserve(count);
  }
  bool full() const override { return sorted_.size() == count_; }
  float worstDist() const override {
    return full() ? bound_above(sorted_.back().squared_distance) : std::numeric_limits<float>::infinity();
  }
  // Few are asked for: moving them up is cheaper than a heap.
  void addPoint(float squared_distance, std::size_t index) override {
    const Neighbour n{static_cast<std::int32_t>(index), squared_distance};
    if (full()) {
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

}  // namespace

class KdTree::Tree {
 public:
  /// The finite points, and which of all points they are.
  Tree(std::vector<Eigen::Vector3f> points, std::vector<std::int32_t> indices)
      : indices_(std::move(indices)),
        index_(flann::Matrix<float>(points.front().data(), points.size(), 3),
               flann::KDTreeSingleIndexParams(leaf_size)) {
    index_.buildIndex();  // copies the points in the order of its leaves
  }

  std::size_t size() const { return indices_.size(); }

  std::size_t memory_bytes() const {
    const std::size_t points = indices_.size() * 3 * sizeof(float);  // FLANN counts its nodes only
    return indices_.capacity() * sizeof(indices_[0]) + points + static_cast<std::size_t>(index_.usedMemory());
  }

  void search(const Eigen::Vector3f& query, flann::ResultSet<float>& found) const {
    index_.findNeighbors(found, query.data(), exact_);
  }

  /// The neighbour with its index into all points.
  Neighbour among_all(const Neighbour& n) const {
    return {indices_[static_cast<std::size_t>(n.index)], n.squared_distance};
  }

 private:
  std::vector<std::int32_t> indices_;
  flann::KDTreeSingleIndex<SquaredDistance> index_;
  flann::SearchParams exact_{flann::FLANN_CHECKS_UNLIMITED, 0};
};

KdTree::KdTree(const std::vector<Eigen::Vector3f>& points) {
  std::vector<Eigen::Vector3f> finite;
  std::vector<std::int32_t> indices;
  finite.reserve(points.size());
  indices.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    finite.push_back(points[i]);
    indices.push_back(static_cast<std::int32_t>(i));
  }
  if (!finite.empty()) tree_ = std::make_unique<const Tree>(std::move(finite), std::move(indices));
}

KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

std::size_t KdTree::size() const {
  return tree_ ? tree_->size() : 0;
}

std::size_t KdTree::memory_bytes() const {
  return tree_ ? tree_->memory_bytes() : 0;
}

KdTree::Neighbour KdTree::nearest(const Eigen::Vector3f& query, float max_distance) const {
  if (!tree_ || !query.allFinite() || !(max_distance >= 0)) return {};
  NearestSearch search(max_distance);
  tree_->search(query, search);
  const Neighbour best = search.best();
  return best.index < 0 ? best : tree_->among_all(best);
}

std::vector<KdTree::Neighbour> KdTree::nearest_few(const Eigen::Vector3f& query, std::size_t count) const {
  std::vector<Neighbour> found;
  nearest_few(query, count, found);
  return found;
}

void KdTree::nearest_few(const Eigen::Vector3f& query, std::size_t count,
                         std::vector<Neighbour>& found) const {
  found.clear();
  if (!tree_ || !query.allFinite() || count == 0) return;
  FewSearch search(std::min(count, tree_->size()), found);
  tree_->search(query, search);
  for (Neighbour& n : found) n = tree_->among_all(n);
}

}  // namespace lcmslam

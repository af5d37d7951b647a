#pragma once
// Exact nearest neighbours by a k-d tree (Friedman, Bentley, Finkel 1977), the thesis's choice. The tree is
// FLANN's, kept out of this header because FLANN's headers clash with OpenCV's. Ties go to the lower index,
// so that the answer does not depend on the tree's shape. tests/bench/bench_kd_tree.cpp has figures.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

namespace lcmslam {

class KdTree {
 public:
  struct Neighbour {
    std::int32_t index = -1;     ///< into the points, -1 when none
    float squared_distance = 0;  ///< m^2
  };

  /// Copies the points; those that are not finite are never found.
  explicit KdTree(const std::vector<Eigen::Vector3f>& points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;

  /// Nearest point at most max_distance away.
  Neighbour nearest(const Eigen::Vector3f& query, float max_distance) const;

  /// The `count` nearest points, nearest first.
  std::vector<Neighbour> nearest_few(const Eigen::Vector3f& query, std::size_t count) const;
  /// The same into a vector whose memory is used again.
  void nearest_few(const Eigen::Vector3f& query, std::size_t count, std::vector<Neighbour>& found) const;

  std::size_t size() const;
  std::size_t memory_bytes() const;

 private:
  class Tree;
  std::unique_ptr<const Tree> tree_;  // null without points
};

}  // namespace lcmslam

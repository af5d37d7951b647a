#pragma once
// Exact nearest neighbours by a k-d tree (Friedman, Bentley, Finkel 1977), the thesis's choice.
// Ties go to the lower index, so that the answer does not depend on the tree's shape.

#include <cstdint>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>

namespace lcmslam {

class KdTree {
 public:
  struct Neighbour {
    std::int32_t index = -1;     ///< into the points, -1 when none
    float squared_distance = 0;  ///< m^2
  };

  /// Copies the points; those that are not finite are never found.
  explicit KdTree(const std::vector<Eigen::Vector3f>& points);

  /// Nearest point at most max_distance away.
  Neighbour nearest(const Eigen::Vector3f& query, float max_distance) const;

  /// The `count` nearest points, nearest first.
  std::vector<Neighbour> nearest_few(const Eigen::Vector3f& query, std::size_t count) const;
  /// The same into a vector whose memory is used again.
  void nearest_few(const Eigen::Vector3f& query, std::size_t count, std::vector<Neighbour>& found) const;

  std::size_t size() const { return order_.size(); }

 private:
  struct Node {
    float split = 0;
    std::int32_t axis = -1;              // -1: leaf
    std::int32_t left = -1, right = -1;  // children, or the range of a leaf
  };
  class NearestSearch;
  class ManySearch;

  std::int32_t build(std::int32_t begin, std::int32_t end);
  template <typename Search>
  void descend(std::int32_t node, const Eigen::Vector3f& query, Eigen::Vector3f offset, Search& search) const;

  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;      // indices as the leaves hold them
  std::vector<Eigen::Vector3f> points_;  // in that order
};

}  // namespace lcmslam

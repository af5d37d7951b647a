#pragma once
// PCL's registrations and k-d tree behind a header without PCL, whose own take 15 s to compile and clash with
// OpenCV's.

#include <memory>
#include <vector>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct PclSettings {
  double max_distance = 0.3;  ///< m
  int max_iterations = 50;
  double epsilon_translation = 5e-4;  ///< m
  double epsilon_rotation = 2e-4;     ///< rad
};

/// Two clouds in PCL's own form, made before the clock runs.
class PclPair {
 public:
  PclPair(const std::vector<Eigen::Vector3f>& source, const std::vector<Eigen::Vector3f>& target);
  ~PclPair();
  PclPair(PclPair&&) noexcept;

  /// T_target_source from the identity; each call builds the trees (and covariances) anew.
  Eigen::Isometry3d icp(const PclSettings& settings) const;   ///< pcl::IterativeClosestPoint
  Eigen::Isometry3d gicp(const PclSettings& settings) const;  ///< pcl::GeneralizedIterativeClosestPoint

 private:
  struct Clouds;
  std::unique_ptr<Clouds> clouds_;
};

/// pcl::KdTreeFLANN with the verbs of our KdTree.
class PclTree {
 public:
  explicit PclTree(const std::vector<Eigen::Vector3f>& points);
  ~PclTree();
  KdTree::Neighbour nearest(const Eigen::Vector3f& query, float max_distance) const;
  void nearest_few(const Eigen::Vector3f& query, std::size_t count,
                   std::vector<KdTree::Neighbour>& found) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace lcmslam

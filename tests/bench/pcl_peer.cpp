#include "tests/bench/pcl_peer.hpp"

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>

#include <cmath>

namespace lcmslam {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

PclCloud::Ptr pcl_cloud(const std::vector<Eigen::Vector3f>& points) {
  PclCloud::Ptr cloud(new PclCloud);
  for (const Eigen::Vector3f& p : points) cloud->emplace_back(p.x(), p.y(), p.z());
  return cloud;
}

template <class Registration>
Eigen::Isometry3d align(Registration& registration, const PclCloud::Ptr& source, const PclCloud::Ptr& target,
                        const PclSettings& settings) {
  registration.setInputSource(source);
  registration.setInputTarget(target);
  registration.setMaxCorrespondenceDistance(settings.max_distance);
  registration.setMaximumIterations(settings.max_iterations);
  PclCloud aligned;
  registration.align(aligned);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.matrix() = registration.getFinalTransformation().template cast<double>();
  return T;
}

}  // namespace

struct PclPair::Clouds {
  PclCloud::Ptr source, target;
};

PclPair::PclPair(const std::vector<Eigen::Vector3f>& source, const std::vector<Eigen::Vector3f>& target)
    : clouds_(new Clouds{pcl_cloud(source), pcl_cloud(target)}) {}
PclPair::~PclPair() = default;
PclPair::PclPair(PclPair&&) noexcept = default;

// ICP takes a squared length and a cosine as thresholds, GICP lengths and angles.
Eigen::Isometry3d PclPair::icp(const PclSettings& settings) const {
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setTransformationEpsilon(settings.epsilon_translation * settings.epsilon_translation);
  icp.setTransformationRotationEpsilon(std::cos(settings.epsilon_rotation));
  return align(icp, clouds_->source, clouds_->target, settings);
}

Eigen::Isometry3d PclPair::gicp(const PclSettings& settings) const {
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setTransformationEpsilon(settings.epsilon_translation);
  gicp.setRotationEpsilon(settings.epsilon_rotation);
  return align(gicp, clouds_->source, clouds_->target, settings);
}

struct PclTree::Tree {
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  pcl::Indices indices;  // used again, as PCL's own registration does
  std::vector<float> squared;
};

PclTree::PclTree(const std::vector<Eigen::Vector3f>& points) : tree_(new Tree) {
  tree_->tree.setInputCloud(pcl_cloud(points));
}
PclTree::~PclTree() = default;

KdTree::Neighbour PclTree::nearest(const Eigen::Vector3f& query, float max_distance) const {
  Tree& t = *tree_;
  const pcl::PointXYZ point(query.x(), query.y(), query.z());
  if (t.tree.radiusSearch(point, max_distance, t.indices, t.squared, 1) == 0) return {};
  return {t.indices[0], t.squared[0]};
}

void PclTree::nearest_few(const Eigen::Vector3f& query, std::size_t count,
                          std::vector<KdTree::Neighbour>& found) const {
  Tree& t = *tree_;
  const pcl::PointXYZ point(query.x(), query.y(), query.z());
  const int n = t.tree.nearestKSearch(point, static_cast<unsigned>(count), t.indices, t.squared);
  found.clear();
  for (int i = 0; i < n; ++i)
    found.push_back({t.indices[static_cast<std::size_t>(i)], t.squared[static_cast<std::size_t>(i)]});
}

}  // namespace lcmslam

#include <lcmslam/cloud/cloud_normals.hpp>

#include <Eigen/Eigenvalues>
#include <limits>

#include <lcmslam/cloud/kd_tree.hpp>

namespace lcmslam {

void estimate_normals(Cloud& cloud, const Eigen::Vector3d& view_point, int neighbours) {
  const KdTree tree(cloud.points);
  cloud.normals.assign(cloud.size(), Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  const auto count = static_cast<std::size_t>(std::max(neighbours, 0));
  std::vector<KdTree::Neighbour> near;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    tree.nearest_few(cloud.points[i], count, near);
    if (near.size() < 3) continue;
    // Sums about the point itself, so that they are exact enough in one pass.
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const auto& n : near) {
      const Eigen::Vector3d d =
          (cloud.points[static_cast<std::size_t>(n.index)] - cloud.points[i]).cast<double>();
      sum += d;
      squares += d * d.transpose();
    }
    const Eigen::Vector3d offset = sum / static_cast<double>(near.size());
    const Eigen::Vector3d mean = cloud.points[i].cast<double>() + offset;
    const Eigen::Matrix3d spread = squares - sum * offset.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    eigen.computeDirect(spread);
    if (!(eigen.eigenvalues()(1) > 1e-4 * eigen.eigenvalues()(2))) continue;
    Eigen::Vector3d normal = eigen.eigenvectors().col(0);
    if (normal.dot(view_point - mean) < 0) normal = -normal;
    cloud.normals[i] = normal.cast<float>();
  }
}

}  // namespace lcmslam

#include "icp/normals.hpp"

#include <Eigen/Eigenvalues>
#include <limits>

#include "icp/kd_tree.hpp"

namespace lcmslam {

void estimate_normals(Cloud& cloud, const Eigen::Vector3d& view_point, int neighbours) {
  const KdTree tree(cloud.points);
  cloud.normals.assign(cloud.size(), Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto near = tree.nearest_few(cloud.points[i], static_cast<std::size_t>(std::max(neighbours, 0)));
    if (near.size() < 3) continue;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& n : near) mean += cloud.points[static_cast<std::size_t>(n.index)].cast<double>();
    mean /= static_cast<double>(near.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const auto& n : near) {
      const Eigen::Vector3d d = cloud.points[static_cast<std::size_t>(n.index)].cast<double>() - mean;
      spread += d * d.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    eigen.computeDirect(spread);
    if (!(eigen.eigenvalues()(1) > 1e-4 * eigen.eigenvalues()(2))) continue;
    Eigen::Vector3d normal = eigen.eigenvectors().col(0);
    if (normal.dot(view_point - mean) < 0) normal = -normal;
    cloud.normals[i] = normal.cast<float>();
  }
}

}  // namespace lcmslam

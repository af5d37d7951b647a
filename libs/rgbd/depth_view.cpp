#include <lcmslam/rgbd/depth_view.hpp>

#include <cmath>

#include <lcmslam/rgbd/rolling_shutter.hpp>

namespace lcmslam {
namespace {

Eigen::Vector3f vector(const cv::Vec3f& v) {
  return {v[0], v[1], v[2]};
}

// One row's points x go to R x + t, and R, t change with the row v of x: the surface is mapped by
// J = R (I + w g'), w = R^-1 d(R x + t)/dv, g = dv/dx, and normals by J^-T = R (I - g w' / (1 + w'g)).
class RowMove {
 public:
  RowMove(int row, int rows, const Eigen::Isometry3d& T_points, const Vector6d& motion, float pitch)
      : T_(row_transform(row, rows, motion) * T_points.cast<float>()), pitch_(pitch) {
    const Eigen::Matrix3f to_raw = T_points.linear().cast<float>().transpose();
    turn_ = to_raw * motion.tail<3>().cast<float>() / static_cast<float>(rows);
    const Eigen::Vector3d lever = motion.tail<3>().cross(T_points.translation());
    shift_ = to_raw * (motion.head<3>() + lever).cast<float>() / static_cast<float>(rows);
    shears_ = !motion.isZero();
  }

  Eigen::Vector3f point(const Eigen::Vector3f& x) const { return T_ * x; }

  Eigen::Vector3f normal(const Eigen::Vector3f& n, const Eigen::Vector3f& x) const {
    if (!shears_) return T_.linear() * n;
    const Eigen::Vector3f w = shift_ + turn_.cross(x);
    const Eigen::Vector3f g = Eigen::Vector3f(0, 1, -x.y() / x.z()) / (pitch_ * x.z());
    const Eigen::Vector3f straight = n - g * (w.dot(n) / (1 + w.dot(g)));
    return T_.linear() * straight.normalized();
  }

 private:
  Eigen::Isometry3f T_;
  float pitch_;
  Eigen::Vector3f turn_, shift_;  // a row's
  bool shears_ = false;
};

}  // namespace

Cloud cloud_of(const DepthView& view, const Eigen::Isometry3d& T_colour_depth_time,
               const Vector6d& row_motion) {
  Cloud cloud;
  const std::size_t most = view.normals.total();
  cloud.points.reserve(most);
  cloud.normals.reserve(most);
  cloud.sigmas.reserve(most);
  for (int v = 0; v < view.points.rows; ++v) {
    const RowMove move(view.step * v, view.rows, T_colour_depth_time, row_motion, view.pitch);
    const auto* point = view.points.ptr<cv::Vec3f>(v);
    const auto* sigma = view.sigma.ptr<float>(v);
    const auto* normal = view.normals.ptr<cv::Vec3f>(v);
    for (int u = 0; u < view.points.cols; ++u) {
      if (std::isnan(point[u][2])) continue;
      const Eigen::Vector3f x = vector(point[u]);
      cloud.points.push_back(move.point(x));
      cloud.normals.push_back(move.normal(vector(normal[u]), x));
      cloud.sigmas.push_back(sigma[u]);
    }
  }
  return cloud;
}

}  // namespace lcmslam

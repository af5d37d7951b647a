#pragma once
// An independent batch solution for recordings of clean depth images: all images at once, each against
// each that sees the same surfaces, point to plane. Shares nothing with the mappers but the camera model.

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam::testing {

/// A depth image as points and normals of the camera frame; normals are zero where there is no plane.
class SurfaceImage {
 public:
  /// depth: CV_16U, mm; f, cx, cy: pixels of a camera without distortion.
  SurfaceImage(const cv::Mat& depth, double f, double cx, double cy)
      : width_(depth.cols),
        height_(depth.rows),
        f_(f),
        cx_(cx),
        cy_(cy),
        points_(depth.total()),
        normals_(depth.total(), Eigen::Vector3d::Zero()) {
    for (int v = 0; v < height_; ++v)
      for (int u = 0; u < width_; ++u) {
        const double z = depth.at<std::uint16_t>(v, u) * 1e-3;
        points_[index(u, v)] = {(u - cx) / f * z, (v - cy) / f * z, z};
      }
    for (int v = reach; v < height_ - reach; v += 2)
      for (int u = reach; u < width_ - reach; u += 2) fit_plane(u, v);
  }

  struct Element {
    Eigen::Vector3d point, normal;
  };
  /// Every `step`-th pixel with a normal.
  std::vector<Element> elements(int step) const {
    std::vector<Element> all;
    for (int v = reach; v < height_; v += step)
      for (int u = reach; u < width_; u += step)
        if (!normals_[index(u, v)].isZero()) all.push_back({points_[index(u, v)], normals_[index(u, v)]});
    return all;
  }
  /// What is seen in the direction of a point of the camera frame.
  const Eigen::Vector3d* seen(const Eigen::Vector3d& p, Eigen::Vector3d& normal) const {
    if (p.z() < 0.2) return nullptr;
    // normals stand at even pixels
    const auto u = 2 * std::lround((p.x() / p.z() * f_ + cx_) / 2);
    const auto v = 2 * std::lround((p.y() / p.z() * f_ + cy_) / 2);
    if (u < 0 || v < 0 || u >= width_ || v >= height_) return nullptr;
    const std::size_t i = index(static_cast<int>(u), static_cast<int>(v));
    normal = normals_[i];
    return normal.isZero() ? nullptr : &points_[i];
  }

 private:
  static constexpr int reach = 4;  // pixels

  std::size_t index(int u, int v) const { return static_cast<std::size_t>(v * width_ + u); }
  void fit_plane(int u, int v) {
    const double z = points_[index(u, v)].z();
    if (z <= 0 || z > 6) return;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    int count = 0;
    for (int j = -reach; j <= reach; j += 2)
      for (int i = -reach; i <= reach; i += 2, ++count) {
        const Eigen::Vector3d& p = points_[index(u + i, v + j)];
        if (std::abs(p.z() - z) > 0.05 * z) return;
        mean += p;
        square += p * p.transpose();
      }
    mean /= count;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    eigen.computeDirect(square / count - mean * mean.transpose());
    if (eigen.eigenvalues()[0] > std::pow(0.003 * z, 2)) return;
    const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
    normals_[index(u, v)] = normal.dot(mean) > 0 ? -normal : normal;
  }

  int width_, height_;
  double f_, cx_, cy_;
  std::vector<Eigen::Vector3d> points_, normals_;
};

struct JointAlignment {
  std::vector<Eigen::Isometry3d> T_world_camera;
  std::size_t pairs = 0;       ///< of images that see a quarter of each other
  double median_residual = 0;  ///< m, point to plane, at the end
};

/// Gauss-Newton over all poses, the first one held; `T_world_camera` are where it begins.
inline JointAlignment align_jointly(const std::vector<SurfaceImage>& images,
                                    std::vector<Eigen::Isometry3d> T_world_camera) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  constexpr std::array gates{0.08, 0.08, 0.08,  0.08,  0.04,  0.04,
                             0.04, 0.04, 0.015, 0.015, 0.015, 0.015};  // m
  const auto n = static_cast<Eigen::Index>(images.size());
  std::vector<std::vector<SurfaceImage::Element>> elements;
  elements.reserve(images.size());
  for (const SurfaceImage& image : images) elements.push_back(image.elements(8));

  JointAlignment result;
  for (const double gate : gates) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(6 * n, 6 * n);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(6 * n);
    std::vector<double> residuals;
    result.pairs = 0;
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) {
        if (i == j) continue;
        const Eigen::Isometry3d& Ti = T_world_camera[static_cast<std::size_t>(i)];
        const Eigen::Isometry3d& Tj = T_world_camera[static_cast<std::size_t>(j)];
        const Eigen::Isometry3d T_j_i = Tj.inverse() * Ti;
        const auto& from = elements[static_cast<std::size_t>(i)];
        Matrix6 h = Matrix6::Zero();
        Vector6 g = Vector6::Zero();
        std::vector<double> of_pair;
        for (const SurfaceImage::Element& e : from) {
          const Eigen::Vector3d p = T_j_i * e.point;
          Eigen::Vector3d normal;
          const Eigen::Vector3d* q = images[static_cast<std::size_t>(j)].seen(p, normal);
          if (q == nullptr || normal.dot(T_j_i.linear() * e.normal) < 0.9) continue;
          const double r = normal.dot(p - *q);
          if (std::abs(r) > gate) continue;
          const Eigen::Vector3d world_normal = Tj.linear() * normal;
          Vector6 jacobian;  // of turning and moving image i about the world's origin; of j the negative
          jacobian << (Ti * e.point).cross(world_normal), world_normal;
          const double weight = 1 / ((1 + std::pow(r / 0.005, 2)) * p.z() * p.z());
          h += weight * jacobian * jacobian.transpose();
          g += weight * r * jacobian;
          of_pair.push_back(std::abs(r));
        }
        if (of_pair.size() * 4 < from.size()) continue;
        ++result.pairs;
        residuals.insert(residuals.end(), of_pair.begin(), of_pair.end());
        hessian.block<6, 6>(6 * i, 6 * i) += h;
        hessian.block<6, 6>(6 * j, 6 * j) += h;
        hessian.block<6, 6>(6 * i, 6 * j) -= h;
        hessian.block<6, 6>(6 * j, 6 * i) -= h;
        gradient.segment<6>(6 * i) += g;
        gradient.segment<6>(6 * j) -= g;
      }
    if (residuals.empty()) return result;
    hessian.topLeftCorner<6, 6>() += 1e9 * Matrix6::Identity();
    const Eigen::VectorXd step = hessian.ldlt().solve(-gradient);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector3d turn = step.segment<3>(6 * i);
      Eigen::Isometry3d correction = Eigen::Isometry3d::Identity();
      if (turn.norm() > 0)
        correction.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
      correction.translation() = step.segment<3>(6 * i + 3);
      auto& pose = T_world_camera[static_cast<std::size_t>(i)];
      pose = correction * pose;
    }
    const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
    std::nth_element(residuals.begin(), middle, residuals.end());
    result.median_residual = *middle;
  }
  result.T_world_camera = std::move(T_world_camera);
  return result;
}

}  // namespace lcmslam::testing

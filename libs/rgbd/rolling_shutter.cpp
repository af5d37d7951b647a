#include <lcmslam/rgbd/rolling_shutter.hpp>

namespace lcmslam {
Eigen::Isometry3f row_transform(double row, int rows, const Vector6d& motion) {
  return se3_exp(((row + 0.5) / rows - 0.5) * motion).cast<float>();
}

void straighten_rows(cv::Mat& points, const Vector6d& motion) {
  if (motion.isZero()) return;
  for (int v = 0; v < points.rows; ++v) {
    const Eigen::Isometry3f T = row_transform(v, points.rows, motion);
    auto* row = points.ptr<cv::Vec3f>(v);
    for (int u = 0; u < points.cols; ++u) {
      const Eigen::Vector3f p = T * Eigen::Vector3f(row[u][0], row[u][1], row[u][2]);
      row[u] = {p.x(), p.y(), p.z()};
    }
  }
}

void straighten_rows(FeatureFrame& features, const Vector6d& motion) {
  if (motion.isZero() || features.height <= 0) return;
  for (Feature& f : features.features)
    if (f.kind == MeasurementKind::point)
      f.point = row_transform(static_cast<double>(f.y), features.height, motion) * f.point;
}

}  // namespace lcmslam

#include <lcmslam/rgbd/rolling_shutter.hpp>

#include <lcmslam/rgbd/camera_motion.hpp>

namespace lcmslam {
namespace {

// us: of the motion that counts, which is about as long as an image is read, and of the gap to the image that
// the last velocity bridges.
constexpr Utime window = 50'000, longest_gap = 200'000;

/// A pixel without depth, seen from the camera turned by R.
void turn(Feature& f, const FeatureFrame& frame, const Eigen::Matrix3f& R) {
  const auto fx = static_cast<float>(frame.fx), fy = static_cast<float>(frame.fy);
  const auto cx = static_cast<float>(frame.cx), cy = static_cast<float>(frame.cy);
  const Eigen::Vector3f ray = R * Eigen::Vector3f((f.x - cx) / fx, (f.y - cy) / fy, 1);
  if (!(ray.z() > 0)) return;
  f.x = cx + fx * ray.x() / ray.z();
  f.y = cy + fy * ray.y() / ray.z();
}

}  // namespace

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
  for (Feature& f : features.features) {
    const Eigen::Isometry3f T = row_transform(static_cast<double>(f.y), features.height, motion);
    if (f.kind == MeasurementKind::point)
      f.point = T * f.point;
    else if (f.kind == MeasurementKind::bearing)
      turn(f, features, T.linear());
  }
}

void straighten_rows(FeatureFrame& features, const MotionBuffer& motion, double rolling_shutter) {
  if (!(rolling_shutter > 0)) return;
  const auto way = motion.between(features.utime - window, features.utime, longest_gap);
  if (!way) return;
  const Vector6d twist = se3_log(camera_motion(*way, features.T_robot_camera)) / (1e-6 * window);
  straighten_rows(features, Vector6d(rolling_shutter * twist));
}

}  // namespace lcmslam

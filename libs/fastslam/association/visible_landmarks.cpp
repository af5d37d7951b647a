#include <lcmslam/fastslam/association/visible_landmarks.hpp>

namespace lcmslam {
namespace {

// What a camera sees, camera frame: the half-space in front of it and those inside of the four planes through
// its centre and the image's borders, `margin` pixels wider.
class ViewPyramid {
 public:
  ViewPyramid(const FeatureFrame& frame, double margin) {
    const double left = frame.cx + margin, right = frame.width - frame.cx + margin;
    const double top = frame.cy + margin, bottom = frame.height - frame.cy + margin;
    inwards_.row(0) << 0, 0, 1;
    inwards_.row(1) << frame.fx, 0, left;
    inwards_.row(2) << -frame.fx, 0, right;
    inwards_.row(3) << 0, frame.fy, top;
    inwards_.row(4) << 0, -frame.fy, bottom;
    inwards_.rowwise().normalize();
  }
  /// False only if no part of the sphere is in view.
  bool touches(const Eigen::Vector3d& centre, double radius) const {
    return (inwards_ * centre).minCoeff() >= -radius;
  }

 private:
  Eigen::Matrix<double, 5, 3> inwards_;  // unit normals
};

}  // namespace

std::vector<VisibleLandmark> visible_landmarks(const LandmarkGrid& grid, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& s) {
  std::vector<VisibleLandmark> visible;
  const Eigen::Isometry3d T_world_camera = T_world_robot * frame.T_robot_camera;
  const Eigen::Isometry3d T_camera_world = T_world_camera.inverse();
  const double margin = s.visibility_margin * frame.width, farthest = 1.1 * s.maximum_range;
  const ViewPyramid pyramid(frame, margin);
  const auto in_view = [&](const Eigen::Vector3d& centre, double radius) {
    const Eigen::Vector3d q = T_camera_world * centre;
    return q.norm() <= farthest + radius && pyramid.touches(q, radius);
  };
  grid.for_each(in_view, [&](const LandmarkGrid::Entry& entry) {
    const Eigen::Vector3d p = T_camera_world * entry.mean;
    if (p.z() < 0.5 * s.minimum_range || p.squaredNorm() > farthest * farthest) return;
    const double x = frame.fx * p.x() / p.z() + frame.cx;
    const double y = frame.fy * p.y() / p.z() + frame.cy;
    if (x < -margin || x > frame.width + margin || y < -margin || y > frame.height + margin) return;
    if (index.alive(entry.slot)) visible.push_back({entry.slot, x, y, p.norm(), entry.mean});
  });
  return visible;
}

std::vector<VisibleLandmark> visible_landmarks(const ParticleMap& map, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& s) {
  LandmarkGrid grid;
  grid.follow(map, index);
  return visible_landmarks(grid, index, T_world_robot, frame, s);
}

}  // namespace lcmslam

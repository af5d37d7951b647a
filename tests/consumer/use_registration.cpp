// Registers two samplings of a room's corner, the second moved by a known transform.

#include <iostream>

#include <lcmslam/registration/registration.hpp>

// Points of a floor and two walls that meet in the origin, `pitch` apart (m), the first half of `shift` from
// the edge.
std::vector<Eigen::Vector3f> corner(float pitch, float shift) {
  std::vector<Eigen::Vector3f> points;
  for (float a = shift; a < 2; a += pitch)
    for (float b = shift; b < 1.5f; b += pitch) {
      points.emplace_back(a, b, 0);
      points.emplace_back(a, 0, b);
      points.emplace_back(0, a, b);
    }
  return points;
}

int main() {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  T_target_source.translate(Eigen::Vector3d(0.12, -0.08, 0.05));
  T_target_source.rotate(Eigen::AngleAxisd(0.06, Eigen::Vector3d(1, 2, 3).normalized()));

  const lcmslam::Cloud target(corner(0.04f, 0.01f));
  const lcmslam::Cloud source =
      lcmslam::transformed(lcmslam::Cloud(corner(0.05f, 0.03f)), T_target_source.inverse());
  const lcmslam::RegistrationResult result =
      lcmslam::register_clouds(source, target, Eigen::Isometry3d::Identity(), lcmslam::wide_passes());

  const Eigen::Isometry3d error = T_target_source.inverse() * result.T_target_source;
  const double rotation = Eigen::AngleAxisd(error.linear()).angle();
  std::cout << "error " << error.translation().norm() << " m, " << rotation << " rad\n";
  return result.ok() && error.translation().norm() < 0.002 && rotation < 0.002 ? 0 : 1;
}

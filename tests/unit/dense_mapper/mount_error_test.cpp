// The robot's path from its cameras' path, with a head that sits elsewhere than is told.

#include <lcmslam/dense_mapper/mount_error.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

const MountErrorSettings settings{0.004, 0.003};

Eigen::Isometry3d placed(double x, double y, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x, y, 0;
  T.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return T;
}

Eigen::Isometry3d mounted() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.2, 0, 1.1;
  T.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()));
  return T * optical_axes();
}

// Draws of the head's true place: the told mean square of the path's errors is theirs.
TEST(MountError, IsWhatDrawnMountsMakeOfThePath) {
  const Eigen::Isometry3d told = mounted(), T = placed(3, -1, 2.5);
  Matrix6d sum = Matrix6d::Zero();
  Random random(3);
  constexpr int draws = 20000;
  for (int i = 0; i < draws; ++i) {
    Vector6d m;
    for (int k = 0; k < 6; ++k)
      m(k) = random.normal(0, k < 3 ? settings.translation_sigma : settings.rotation_sigma);
    const Eigen::Isometry3d built = told * se3_exp(m);
    const Eigen::Isometry3d T_first_now_camera = built.inverse() * T * built;  // as the cameras see it
    const Vector6d error = se3_log((told * T_first_now_camera * told.inverse()).inverse() * T);
    sum += error * error.transpose() / draws;
  }
  const Matrix6d P = mount_error(T, told, settings);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(P(i, j), sum(i, j), 0.05 * std::sqrt(P(i, i) * P(j, j)) + 1e-9) << i << " " << j;
}

TEST(MountError, IsNothingAtTheStartAndForACameraInTheHand) {
  EXPECT_LT(mount_error(placed(0, 0, 0), mounted(), settings).norm(), 1e-18);
  EXPECT_EQ(mount_error(placed(3, 1, 1), optical_axes(), settings).norm(), 0);
}

}  // namespace
}  // namespace lcmslam

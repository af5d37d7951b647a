#include <gtest/gtest.h>

#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "tests/unit/geometry/random_poses.hpp"

namespace lcmslam {
namespace {

constexpr double pi = 3.14159265358979323846;

class TransformProperty : public testing::TestWithParam<int> {
 protected:
  Random random_{static_cast<std::uint64_t>(GetParam())};
};

Eigen::Matrix4d twist_matrix(const Vector6d& xi) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m.topLeftCorner<3, 3>() = hat(xi.tail<3>());
  m.topRightCorner<3, 1>() = xi.head<3>();
  return m;
}

TEST_P(TransformProperty, HatIsTheCrossProduct) {
  const Eigen::Vector3d a = random_vector(random_, 1);
  const Eigen::Vector3d b = random_vector(random_, 1);
  EXPECT_LT((hat(a) * b - a.cross(b)).norm(), 1e-15);
}

TEST_P(TransformProperty, ExponentialIsTheMatrixExponential) {
  Vector6d xi;
  xi << random_vector(random_, 1), random_vector(random_, 0.8);
  const Eigen::Matrix4d expected = twist_matrix(xi).exp();
  EXPECT_LT((se3_exp(xi).matrix() - expected).norm(), 1e-12);
}

TEST_P(TransformProperty, LogarithmInvertsTheExponential) {
  for (const double angle : {0.0, 1e-12, 1e-9, 9e-5, 1.1e-4, 1e-2, 1.0, 3.0, pi - 1e-6}) {
    Vector6d xi;
    xi << random_vector(random_, 1), angle * random_vector(random_, 1).normalized();
    EXPECT_LT((se3_log(se3_exp(xi)) - xi).norm(), 1e-8) << "angle " << angle;
    EXPECT_LT((so3_log(so3_exp(xi.tail<3>())) - xi.tail<3>()).norm(), 1e-8) << "angle " << angle;
  }
}

TEST_P(TransformProperty, ExponentialIsRigid) {
  const Eigen::Matrix3d R = random_transform(random_).linear();
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_NEAR(R.determinant(), 1, 1e-14);
}

TEST_P(TransformProperty, AdjointMovesTwistsAcross) {
  const Eigen::Isometry3d T = random_transform(random_);
  Vector6d xi;
  xi << random_vector(random_, 0.5), random_vector(random_, 0.3);
  const Eigen::Isometry3d left = T * se3_exp(xi);
  const Eigen::Isometry3d right = se3_exp(adjoint(T) * xi) * T;
  EXPECT_LT((left.matrix() - right.matrix()).norm(), 1e-12);
}

TEST_P(TransformProperty, AdjointIsAHomomorphism) {
  const Eigen::Isometry3d A = random_transform(random_);
  const Eigen::Isometry3d B = random_transform(random_);
  EXPECT_LT((adjoint(A * B) - adjoint(A) * adjoint(B)).norm(), 1e-12);
  EXPECT_LT((adjoint(A.inverse()) * adjoint(A) - Matrix6d::Identity()).norm(), 1e-12);
}

TEST_P(TransformProperty, InterpolationHasConstantVelocity) {
  const Eigen::Isometry3d a = random_transform(random_);
  const Eigen::Isometry3d b = a * random_transform(random_, 2.0);
  EXPECT_LT((interpolate(a, b, 0).matrix() - a.matrix()).norm(), 1e-12);
  EXPECT_LT((interpolate(a, b, 1).matrix() - b.matrix()).norm(), 1e-9);
  const Eigen::Isometry3d half = interpolate(a, b, 0.5);
  EXPECT_LT(((a.inverse() * half).matrix() - (half.inverse() * b).matrix()).norm(), 1e-9);
}

TEST_P(TransformProperty, QuaternionOrderIsWxyz) {
  const Eigen::Isometry3d T = random_transform(random_);
  const Eigen::Quaterniond q(T.linear());
  const double translation[3] = {T.translation().x(), T.translation().y(), T.translation().z()};
  const double scaled_wxyz[4] = {2 * q.w(), 2 * q.x(), 2 * q.y(), 2 * q.z()};  // normalised on the way
  EXPECT_LT((make_transform(translation, scaled_wxyz).matrix() - T.matrix()).norm(), 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TransformProperty, testing::Range(1, 21));

TEST(Transform, PlanarPoseAndYaw) {
  const Eigen::Isometry3d T = planar_pose(1, -2, 0.7);
  EXPECT_NEAR(yaw(T), 0.7, 1e-15);
  EXPECT_NEAR(rotation_angle(T), 0.7, 1e-12);
  EXPECT_LT((T * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1 + std::cos(0.7), -2 + std::sin(0.7), 0)).norm(),
            1e-15);
}

TEST(Transform, OpticalAxesMapForwardLeftUp) {
  const Eigen::Isometry3d T_robot_camera = optical_axes();
  EXPECT_EQ(T_robot_camera * Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 0, 0));   // forward
  EXPECT_EQ(T_robot_camera * Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0));  // right
  EXPECT_EQ(T_robot_camera * Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, -1));  // down
}

}  // namespace
}  // namespace lcmslam

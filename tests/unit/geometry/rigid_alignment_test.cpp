#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include <lcmslam/geometry/rigid_alignment.hpp>
#include "tests/unit/geometry/random_poses.hpp"

namespace lcmslam {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points random_points(Random& random, int count, const Eigen::Vector3d& scale = Eigen::Vector3d::Ones()) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(random_vector(random, 1).cwiseProduct(scale));
  return points;
}

double error(const RigidAlignment& found, const Eigen::Isometry3d& truth) {
  return (found.T_target_source.matrix() - truth.matrix()).norm();
}

// The estimators that give the exact minimum at any angle.
class ExactEstimator : public testing::TestWithParam<std::shared_ptr<RigidEstimator>> {};
INSTANTIATE_TEST_SUITE_P(Estimators, ExactEstimator,
                         testing::Values(std::make_shared<SvdEstimator>(),
                                         std::make_shared<QuaternionEstimator>()));

TEST_P(ExactEstimator, NoiseFreePairsGiveTheTransformExactly) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Points source = random_points(random, 3 + static_cast<int>(seed));
    const Eigen::Isometry3d T = random_transform(random);
    const RigidAlignment found = GetParam()->estimate(source, moved(source, T));
    ASSERT_EQ(found.status, AlignmentStatus::ok);
    EXPECT_LT(error(found, T), 1e-12);
  }
}

TEST_P(ExactEstimator, PlanarPointsDoNotBecomeAReflection) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Points source = random_points(random, 10, Eigen::Vector3d(1, 1, 0));
    const Eigen::Isometry3d T = random_transform(random);
    const RigidAlignment found = GetParam()->estimate(source, moved(source, T));
    ASSERT_EQ(found.status, AlignmentStatus::ok);
    EXPECT_LT(error(found, T), 1e-12);
  }
}

TEST_P(ExactEstimator, NoiseNeverMakesAReflection) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Points source = random_points(random, 4, Eigen::Vector3d(1, 1, 0.01));
    Points target = random_points(random, 4, Eigen::Vector3d(1, 1, 0.01));  // nothing in common
    const RigidAlignment found = GetParam()->estimate(source, target);
    ASSERT_EQ(found.status, AlignmentStatus::ok);
    EXPECT_NEAR(found.T_target_source.linear().determinant(), 1, 1e-9);
  }
}

// At the minimum no small motion lowers the weighted squared error.
TEST_P(ExactEstimator, WeightedNoisyPairsReachTheMinimum) {
  Random random(5);
  const Points source = random_points(random, 40);
  const Eigen::Isometry3d T = random_transform(random);
  Points target = moved(source, T);
  std::vector<double> weights;
  for (auto& q : target) {
    q += random_vector(random, 0.05);
    weights.push_back(random.uniform(0, 2));
  }
  const auto cost = [&](const Eigen::Isometry3d& candidate) {
    double sum = 0;
    for (std::size_t i = 0; i < source.size(); ++i)
      sum += weights[i] * (candidate * source[i] - target[i]).squaredNorm();
    return sum;
  };
  const RigidAlignment found = GetParam()->estimate(source, target, weights);
  ASSERT_EQ(found.status, AlignmentStatus::ok);
  const double least = cost(found.T_target_source);
  for (int axis = 0; axis < 6; ++axis)
    for (const double h : {-1e-3, 1e-3})
      EXPECT_GT(cost(found.T_target_source * se3_exp(h * Vector6d::Unit(axis))), least);
}

TEST_P(ExactEstimator, PairsOfWeightZeroDoNotCount) {
  Random random(6);
  Points source = random_points(random, 10);
  const Eigen::Isometry3d T = random_transform(random);
  Points target = moved(source, T);
  target[3] += Eigen::Vector3d(100, 0, 0);
  std::vector<double> weights(10, 1);
  weights[3] = 0;
  EXPECT_LT(error(GetParam()->estimate(source, target, weights), T), 1e-12);
}

// The linear step's error falls with the square of the angle, and iterating it converges.
TEST(SmallAngle, ErrorIsOfSecondOrder) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Points source = random_points(random, 30);
    const Eigen::Vector3d axis = random_vector(random, 1).normalized();
    const auto error_at = [&](double angle) {
      Vector6d twist;
      twist << 1, 2, 3, angle * axis;
      const Eigen::Isometry3d T = se3_exp(twist);
      const RigidAlignment found = SmallAngleEstimator().estimate(source, moved(source, T));
      return rotation_angle(found.T_target_source.inverse() * T);
    };
    EXPECT_LT(error_at(0.01), 2 * 0.01 * 0.01);
    EXPECT_LT(error_at(0.1), 2 * 0.1 * 0.1);
  }
}

TEST(SmallAngle, IterationIsExact) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Points source = random_points(random, 30);
    const Eigen::Isometry3d T = random_transform(random, 1.0);
    const Points target = moved(source, T);
    Eigen::Isometry3d found = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 60; ++i)
      found = SmallAngleEstimator().estimate(moved(source, found), target).T_target_source * found;
    EXPECT_LT((found.matrix() - T.matrix()).norm(), 1e-12);
  }
}

TEST(SmallAngle, RecomposedIsARotationAsPrintedIsNot) {
  Random random(8);
  const Points source = random_points(random, 30);
  const Points target = moved(source, random_transform(random, 0.5) * planar_pose(0, 0, 0.5));
  const auto determinant = [&](SmallAngleEstimator::Form form) {
    return SmallAngleEstimator(form).estimate(source, target).T_target_source.linear().determinant();
  };
  EXPECT_NEAR(determinant(SmallAngleEstimator::Form::recomposed), 1, 1e-12);
  EXPECT_GT(determinant(SmallAngleEstimator::Form::as_printed), 1.01);  // 1 + |omega|^2
}

TEST(SvdUncorrected, GivesTheReflectionThatTheCorrectionAvoids) {
  Random random(9);
  const Points source = random_points(random, 20);
  Points mirrored = source;
  for (auto& p : mirrored) p.z() = -p.z();
  const auto determinant = [&](bool correct) {
    return SvdEstimator(correct).estimate(source, mirrored).T_target_source.linear().determinant();
  };
  EXPECT_NEAR(determinant(true), 1, 1e-12);
  EXPECT_NEAR(determinant(false), -1, 1e-12);
}

// Even pairs that coincide turn, unless their axes of spread are the coordinates'.
TEST(QuaternionAsPrinted, IsAnotherRotation) {
  const QuaternionEstimator printed(QuaternionEstimator::Form::as_printed);
  const auto angle = [&](const Points& points) {
    return rotation_angle(printed.estimate(points, points).T_target_source);
  };
  const Points along_axes = {{3, 0, 0}, {-3, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 1}, {0, 0, -1}};
  EXPECT_NEAR(angle(along_axes), 0, 1e-12);
  Random random(12);
  const Points points = random_points(random, 20, {3, 2, 1});
  const Eigen::Isometry3d turned = se3_exp((Vector6d() << 0, 0, 0, 0.3, 0.4, 0.5).finished());
  EXPECT_GT(angle(moved(points, turned)), 0.1);
  const Eigen::Matrix3d R = printed.estimate(points, moved(points, turned)).T_target_source.linear();
  EXPECT_NEAR(R.determinant(), 1, 1e-12);  // a rotation all the same
}

class AnyEstimator : public testing::TestWithParam<std::shared_ptr<RigidEstimator>> {
 protected:
  void expect(const Points& source, const Points& target, AlignmentStatus status,
              const std::vector<double>& weights = {}) {
    const RigidAlignment found = GetParam()->estimate(source, target, weights);
    EXPECT_EQ(to_string(found.status), to_string(status));
    EXPECT_EQ(error(found, Eigen::Isometry3d::Identity()), 0);
  }
};
INSTANTIATE_TEST_SUITE_P(
    Estimators, AnyEstimator,
    testing::Values(std::make_shared<SvdEstimator>(), std::make_shared<SvdEstimator>(false),
                    std::make_shared<QuaternionEstimator>(),
                    std::make_shared<QuaternionEstimator>(QuaternionEstimator::Form::as_printed),
                    std::make_shared<SmallAngleEstimator>(),
                    std::make_shared<SmallAngleEstimator>(SmallAngleEstimator::Form::as_printed)));

TEST_P(AnyEstimator, DegenerateSetsHaveAStatus) {
  Random random(10);
  const Eigen::Isometry3d T = random_transform(random);
  const auto check = [&](const Points& source, AlignmentStatus status) {
    expect(source, moved(source, T), status);
  };
  check({}, AlignmentStatus::too_few);
  check({{1, 2, 3}}, AlignmentStatus::too_few);
  check({{1, 2, 3}, {2, 2, 3}}, AlignmentStatus::too_few);
  check(Points(20, Eigen::Vector3d(0.1, 0.2, 0.3)), AlignmentStatus::coincident);
  check(Points(20, Eigen::Vector3d(1000.1, -2000.2, 3000.3)), AlignmentStatus::coincident);
  check(Points(20, Eigen::Vector3d::Zero()), AlignmentStatus::coincident);
  Points line;
  for (int i = 0; i < 20; ++i)
    line.push_back(Eigen::Vector3d(1, 2, 3) + 0.37 * i * Eigen::Vector3d(1, 1, -2));
  check(line, AlignmentStatus::collinear);
}

TEST_P(AnyEstimator, BadInputHasAStatus) {
  Random random(11);
  const Points good = random_points(random, 5);
  expect(good, random_points(random, 4), AlignmentStatus::bad_input);
  expect(good, good, AlignmentStatus::bad_input, {1, 1});
  expect(good, good, AlignmentStatus::bad_input, {1, 1, 1, 1, -1});
  expect(good, good, AlignmentStatus::too_few, {1, 1, 0, 0, 0});
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Points broken = good;
    broken[2].y() = bad;
    expect(broken, good, AlignmentStatus::bad_input);
    expect(good, broken, AlignmentStatus::bad_input);
    expect(good, good, AlignmentStatus::bad_input, {1, bad, 1, 1, 1});
  }
}

TEST(AlignSvd, IsNothingForDegenerateSets) {
  EXPECT_FALSE(align_svd({}, {}));
  const Points point(5, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(align_svd(point, point));
}

TEST(AlignSvd, ReturnsTheTransform) {
  Random random(12);
  const Points source = random_points(random, 5);
  const Eigen::Isometry3d T = random_transform(random);
  const auto found = align_svd(source, moved(source, T));
  ASSERT_TRUE(found);
  EXPECT_LT((found->matrix() - T.matrix()).norm(), 1e-12);
}

}  // namespace
}  // namespace lcmslam

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/planes/plane_moments.hpp>

namespace lcmslam {
namespace {

/// A plate of 0.6 m x 0.2 m at x = 1, its normal -x, with noise across it.
PlaneMoments plate(Random& random, double sigma, int points = 200) {
  PlaneMoments moments;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector3d p(1 + sigma * random.normal(), random.uniform(-0.3, 0.3),
                            random.uniform(-0.1, 0.1));
    const double weight = 1 / (sigma * sigma);
    moments.weight += weight;
    moments.points += 1;
    moments.sum += weight * p;
    moments.squares += weight * p * p.transpose();
  }
  return moments;
}

TEST(PlaneMoments, TheNormalLooksToWhereThePlaneWasSeenFrom) {
  Random random(1);
  const PlaneMoments moments = plate(random, 0.001);
  EXPECT_LT(moments.fit({0, 0, 0}).plane.normal.x(), -0.999);
  EXPECT_GT(moments.fit({2, 0, 0}).plane.normal.x(), 0.999);
  EXPECT_NEAR(moments.fit({0, 0, 0}).plane.offset, 1, 1e-3);
  EXPECT_NEAR(moments.fit({0, 0, 0}).rms, 0.001, 2e-4);
}

TEST(PlaneMoments, MovedMomentsAreTheMovedPlanes) {
  Random random(2);
  const PlaneMoments moments = plate(random, 0.002);
  Vector6d twist;
  twist << 0.4, -1.2, 0.3, 0.5, -0.9, 1.1;
  const Eigen::Isometry3d T = se3_exp(twist);
  const PlaneFit here = moments.fit({0, 0, 0}), there = moments.moved(T).fit(T.translation());
  EXPECT_LT((there.plane.normal - T.linear() * here.plane.normal).norm(), 1e-6);
  EXPECT_LT((there.centre - T * here.centre).norm(), 1e-9);
  EXPECT_LT((there.variance - here.variance).norm(), 1e-3 * here.variance.norm());
}

TEST(PlaneMoments, NoiseAlongSlantedRaysIsNoTilt) {
  // A strip of 0.1 m, 2.5 m away and seen at 70 degrees, in many noisy frames.
  const double slant = 1.22, sigma = 0.01;
  const Eigen::Vector3d normal(std::sin(slant), 0, -std::cos(slant)),
      along(std::cos(slant), 0, std::sin(slant));
  Random random(4);
  PlaneMoments frames;
  for (int frame = 0; frame < 100; ++frame) {
    PlaneMoments seen;
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d place = Eigen::Vector3d(0, 0, 2.5) + random.uniform(-0.05, 0.05) * along +
                                    Eigen::Vector3d(0, random.uniform(-0.2, 0.2), 0);
      seen.add(place * (1 + sigma * random.normal() / place.z()));
    }
    frames.add(seen.weighed(sigma));
  }
  const auto error = [&](const PlaneMoments& moments, const Eigen::Vector3d& wanted) {
    return std::acos(std::min(1.0, moments.fit({0, 0, 0}).plane.normal.dot(wanted)));
  };
  EXPECT_LT(error(frames, normal), 0.003);
  const Eigen::Isometry3d T(Eigen::AngleAxisd(2, Eigen::Vector3d(1, 2, 3).normalized()));
  EXPECT_LT(error(frames.moved(T), T.linear() * normal), 0.003);
  frames.rays.setZero();
  EXPECT_GT(error(frames, normal), 0.02) << "what least squares of distances would give";
}

TEST(PlaneMoments, PointsLieOffAnyPlaneByTheirOwnDistances) {
  PlaneMoments moments;
  for (const double x : {1.0, 2.0, 4.0}) moments.add({x, -3 * x, 5});
  EXPECT_NEAR(moments.rms_from({{1, 0, 0}, -2}), std::sqrt((1 + 0 + 4) / 3.0), 1e-12);
}

TEST(PlaneMoments, TheVarianceIsThatOfManyFits) {
  const std::uint64_t seed = 5;
  SCOPED_TRACE(seed);
  Random random(seed);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero(), variance = Eigen::Vector3d::Zero();
  const int runs = 600;
  for (int run = 0; run < runs; ++run) {
    const PlaneFit fit = plate(random, 0.01).fit({0, 0, 0});
    // The long axis is y: tilting about it shows in the normal's z, about z in its y.
    const Eigen::Vector3d error(fit.plane.normal.z(), fit.plane.normal.y(),
                                fit.plane.distance({1, fit.centre.y(), fit.centre.z()}));
    squares += error.cwiseProduct(error) / runs;
    variance += fit.variance / runs;
  }
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(squares[i] / variance[i], 1, 0.25) << i;
}

}  // namespace
}  // namespace lcmslam

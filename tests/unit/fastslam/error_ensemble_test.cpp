// What an ensemble of errors says of pose and landmarks, against what is known exactly.

#include <lcmslam/fastslam/error_ensemble.hpp>

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {
namespace {

constexpr double noise = 1e-4;    // m^2, of a measured point
constexpr double sampled = 0.45;  // of a variance: two to three sigmas of what 64 members tell of it

FastSlamSettings planar(std::uint64_t seed = 1) {
  FastSlamSettings settings;
  settings.seed = seed;
  settings.minimum_landmark_sigma = 0;
  return settings;
}

/// Landmarks around a place, each seen with independent errors. The filter's variance of a landmark after n
/// observations from known poses is noise / n.
class ErrorEnsembleTest : public ::testing::Test {
 protected:
  std::vector<EnsembleObservation> look(const std::vector<int>& slots,
                                        const Eigen::Isometry3d& T_world_robot) {
    std::vector<EnsembleObservation> seen;
    for (const int slot : slots) {
      EnsembleObservation o;
      o.slot = slot;
      const double angle = 0.7 * slot;
      o.landmark.mean << 3 * std::cos(angle) + 0.05 * slot, 3 * std::sin(angle), 0.3 * (slot % 5);
      ++looks_.at(static_cast<std::size_t>(slot));
      o.landmark.covariance = noise / looks_.at(static_cast<std::size_t>(slot)) * Eigen::Matrix3d::Identity();
      o.measurement.value = T_world_robot.inverse() * o.landmark.mean;
      o.measurement.covariance = noise * Eigen::Matrix3d::Identity();
      o.error = static_cast<float>(std::sqrt(noise)) *
                random_signs({random_.bits(), random_.bits(), random_.bits()});
      seen.push_back(o);
    }
    return seen;
  }
  static std::vector<int> slots(int from, int to) {
    std::vector<int> all;
    for (int slot = from; slot < to; ++slot) all.push_back(slot);
    return all;
  }
  static Motion standing(double variance) {
    Motion motion;
    motion.covariance = variance * Matrix6d::Identity();
    return motion;
  }

  Random random_{5};
  std::vector<int> looks_ = std::vector<int>(2000, 0);
  const Eigen::Isometry3d here_ = Eigen::Isometry3d::Identity();
};

TEST_F(ErrorEnsembleTest, KnowsTheFirstPose) {
  const ErrorEnsemble ensemble(planar());
  EXPECT_EQ(ensemble.pose(), Matrix6d::Zero());
}

// Q_2 = Ad(T^-1) Q_1 Ad(T^-1)^T + Q: an error of the heading becomes one of the place with the way.
TEST_F(ErrorEnsembleTest, GrowsAsTheOdometryErrs) {
  Matrix6d sum = Matrix6d::Zero();
  Motion turn = standing(0), way = standing(0);
  turn.covariance(5, 5) = 1e-4;
  way.T_from_to = planar_pose(10, 0, 0);
  way.covariance(0, 0) = 4e-4;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ErrorEnsemble ensemble(planar(seed));
    ensemble.move(turn);
    ensemble.move(way);
    sum += ensemble.pose() / 20;
  }
  const double wider = 64.0 / 60;  // for the sake of NEES
  EXPECT_NEAR(sum(0, 0), wider * 4e-4, 0.4e-4);
  EXPECT_NEAR(sum(1, 1), wider * 100e-4, 10e-4);
  EXPECT_NEAR(sum(1, 5), wider * 10e-4, 1e-4);
  EXPECT_NEAR(sum(5, 5), wider * 1e-4, 0.1e-4);
}

TEST_F(ErrorEnsembleTest, OfDrawsTellsMoreWhereThePlaneIsLeft) {
  FastSlamSettings settings = planar();
  settings.draw_share = 0;
  settings.free_draw_share = 1;
  ErrorEnsemble ensemble(settings);
  auto exact = look(slots(0, 5), here_);
  for (EnsembleObservation& o : exact) o.error.setZero();
  ensemble.create(exact, here_);
  const Matrix6d prior = 1e-4 * Matrix6d::Identity();
  ensemble.observe(exact, here_, prior);
  EXPECT_LT(ensemble.pose().trace(), 1e-10);
  ensemble.leave_plane();
  ensemble.observe(exact, here_, prior);
  EXPECT_GT(ensemble.pose().trace(), 1e-8);
}

TEST_F(ErrorEnsembleTest, StaysInThePlaneUntilItIsLeft) {
  ErrorEnsemble ensemble(planar());
  ensemble.move(standing(1e-4));
  EXPECT_EQ(ensemble.pose()(2, 2), 0);
  EXPECT_EQ(ensemble.pose()(3, 3), 0);
  ensemble.leave_plane();
  ensemble.move(standing(1e-4));
  EXPECT_NEAR(ensemble.pose()(2, 2), 1e-4, 0.5e-4);
  EXPECT_GT(ensemble.pose()(5, 5), 1.2e-4);
}

// With exact measurements of exact landmarks nothing but the draw errs.
TEST_F(ErrorEnsembleTest, TellsItsShareOfTheDraws) {
  const auto drawn = [&](double share) {
    FastSlamSettings settings = planar();
    settings.draw_share = share;
    ErrorEnsemble ensemble(settings);
    auto exact = look(slots(0, 5), here_);
    for (EnsembleObservation& o : exact) o.error.setZero();
    ensemble.create(exact, here_);
    ensemble.observe(exact, here_, Matrix6d(1e-4 * Matrix6d::Identity()));
    std::fill(looks_.begin(), looks_.end(), 0);
    return ensemble.pose();
  };
  const Matrix6d whole = drawn(1), quarter = drawn(0.25);
  EXPECT_GT(whole(0, 0), 1e-6);
  EXPECT_TRUE(quarter.isApprox(0.25 * whole, 1e-4)) << quarter(0, 0) << " of " << whole(0, 0);
}

// New landmarks err as the pose and the measurement do.
TEST_F(ErrorEnsembleTest, LandmarksErrWithThePoseThatMadeThem) {
  double near = 0, far = 0;
  Motion turn = standing(0);
  turn.covariance(5, 5) = 1e-4;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ErrorEnsemble ensemble(planar(seed));
    ensemble.move(turn);
    auto made = look({0, 1}, here_);
    made[0].landmark.mean << 1, 0, 0;
    made[1].landmark.mean << 10, 0, 0;
    ensemble.create(made, here_);
    near += ensemble.landmark(0)(1, 1) / 20;
    far += ensemble.landmark(1)(1, 1) / 20;
  }
  EXPECT_NEAR(near, 2e-4, 0.4e-4);
  EXPECT_NEAR(far, 101e-4, 15e-4);
}

// A robot that knows nothing but landmarks whose places are certain: (sum J^T R^-1 J)^-1, once for the
// measurements and once for the draw.
TEST_F(ErrorEnsembleTest, ThePoseAmongLandmarksIsThatOfTheirEquations) {
  FastSlamSettings settings = planar();
  settings.draw_share = 1;
  ErrorEnsemble ensemble(settings);
  auto made = look(slots(0, 40), here_);
  for (auto& landmark : made) landmark.error.setZero();
  ensemble.create(made, here_);
  auto seen = look(slots(0, 40), here_);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (auto& s : seen) {
    s.landmark.covariance = 1e-12 * Eigen::Matrix3d::Identity();  // known before
    information += PoseSpace<3>::normal_matrix(Eigen::Matrix3d::Identity() / noise, s.measurement.value);
  }
  ensemble.observe(seen, here_, std::nullopt);
  const Eigen::Matrix3d expected = 2 * information.inverse();
  const Eigen::Matrix3d P = PoseSpace<3>::reduce(ensemble.pose());
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(P(i, i), expected(i, i), sampled * expected(i, i));
}

// From one generation of landmarks to the next it grows; the first ones bring it back.
TEST_F(ErrorEnsembleTest, GrowsIntoNewGroundAndShrinksAtTheLoop) {
  ErrorEnsemble ensemble(planar());
  const auto see = [&](int from) {
    ensemble.move(standing(1e-4));
    ensemble.observe(look(slots(from, from + 40), here_), here_, 1e-4 * Matrix6d::Identity());
  };
  ensemble.create(look(slots(0, 40), here_), here_);
  for (int i = 0; i < 5; ++i) see(0);
  const double first = ensemble.pose()(5, 5);
  for (int generation = 1; generation <= 30; ++generation) {
    ensemble.create(look(slots(40 * generation, 40 * generation + 40), here_), here_);
    for (int i = 0; i < 5; ++i) see(40 * generation);
  }
  const double astray = ensemble.pose()(5, 5);
  EXPECT_GT(astray, 4 * first);
  EXPECT_GT(ensemble.landmark(40 * 30)(0, 0), 2 * ensemble.landmark(0)(0, 0));
  see(0);
  EXPECT_LT(ensemble.pose()(5, 5), 2 * first);
}

// A bearing that moved its landmark to just before the camera: its update was made about another place, and
// by the equations of this one it would tell less than nothing.
TEST_F(ErrorEnsembleTest, ABearingOfAnotherPlaceTellsNothing) {
  EnsembleObservation bearing;
  bearing.slot = 20;
  bearing.landmark.mean = {0.01, 0.02, 0.2};
  bearing.landmark.covariance = 4e-6 * Eigen::Matrix3d::Identity();
  bearing.measurement.kind = MeasurementKind::bearing;
  bearing.measurement.T_robot_camera = &here_;
  bearing.measurement.value = {0.05, 0.1, 0};
  bearing.measurement.covariance.diagonal() << 4e-6, 4e-6, 1;
  bearing.error.setConstant(0.002F);

  const auto pose_after = [&](const std::vector<EnsembleObservation>& more) {
    random_ = Random(5);
    looks_.assign(looks_.size(), 0);
    ErrorEnsemble ensemble(planar());
    ensemble.create(look(slots(0, 21), here_), here_);
    auto seen = look(slots(0, 20), here_);
    seen.insert(seen.end(), more.begin(), more.end());
    ensemble.observe(seen, here_, std::nullopt);
    return ensemble.pose();
  };
  EXPECT_TRUE(pose_after({bearing}).isApprox(pose_after({}), 1e-6));
  bearing.landmark.covariance /= 100;  // it fits: the same is heard
  EXPECT_FALSE(pose_after({bearing}).isApprox(pose_after({}), 1e-6));
}

// An error that all measurements share goes the same way in every generation: a drift and no walk.
TEST_F(ErrorEnsembleTest, ASharedErrorMakesADrift) {
  const auto heading_after = [&](int generations) {
    looks_.assign(looks_.size(), 0);
    ErrorEnsemble ensemble(planar());
    const EnsembleRow shared = 0.01F * random_signs({random_.bits(), 0, 0}).row(0);
    const auto err = [&](std::vector<EnsembleObservation> seen, double side) {
      for (auto& s : seen) {
        const Eigen::Vector3f aside = Eigen::Vector3d(0, 0, side).cross(s.measurement.value).cast<float>();
        s.error = 0.01F * s.error + aside.lazyProduct(shared);
      }
      return seen;
    };
    ensemble.create(err(look(slots(0, 20), here_), 0), here_);
    for (int g = 0; g < generations; ++g) {
      ensemble.observe(err(look(slots(20 * g, 20 * g + 20), here_), 1), here_, std::nullopt);
      ensemble.create(err(look(slots(20 * g + 20, 20 * g + 40), here_), 0), here_);
    }
    return std::sqrt(ensemble.pose()(5, 5));
  };
  const double once = heading_after(10);
  EXPECT_NEAR(heading_after(40), 4 * once, 0.8 * once);
}

}  // namespace
}  // namespace lcmslam

// Every combination of parts through one check on recorded pairs; garbage.

#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include <lcmslam/registration/registration.hpp>
#include "tests/support/recorded_clouds.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/targets.hpp"
#include "tests/unit/registration/register_to_itself.hpp"

namespace lcmslam {
namespace {

struct Combination {
  const char* name;
  MetricKind metric;
  SolverKind solver;
  CorrespondenceKind correspondence;
  KernelKind kernel;
};

const Combination combinations[] = {
    {"svd", MetricKind::point_to_point, SolverKind::svd, CorrespondenceKind::kd_tree, KernelKind::huber},
    {"quaternion", MetricKind::point_to_point, SolverKind::quaternion, CorrespondenceKind::kd_tree,
     KernelKind::geman_mcclure},
    {"small_angle", MetricKind::point_to_point, SolverKind::small_angle, CorrespondenceKind::kd_tree,
     KernelKind::huber},
    {"point_gauss_newton", MetricKind::point_to_point, SolverKind::gauss_newton, CorrespondenceKind::kd_tree,
     KernelKind::none},
    {"plane_none", MetricKind::point_to_plane, SolverKind::gauss_newton, CorrespondenceKind::kd_tree,
     KernelKind::none},
    {"plane_huber", MetricKind::point_to_plane, SolverKind::gauss_newton, CorrespondenceKind::kd_tree,
     KernelKind::huber},
    {"plane_geman_mcclure", MetricKind::point_to_plane, SolverKind::gauss_newton, CorrespondenceKind::kd_tree,
     KernelKind::geman_mcclure},
    {"plane_projective", MetricKind::point_to_plane, SolverKind::gauss_newton, CorrespondenceKind::projective,
     KernelKind::geman_mcclure},
    {"point_projective", MetricKind::point_to_point, SolverKind::svd, CorrespondenceKind::projective,
     KernelKind::geman_mcclure}};

RegistrationSettings settings_of(const Combination& c) {
  RegistrationSettings s;
  s.metric = c.metric;
  s.solver = c.solver;
  s.kernel = c.kernel;
  s.max_iterations = 60;
  if (c.metric == MetricKind::point_to_point) {  // slides slowly along surfaces
    s.weigh_by_noise = false;
    s.max_iterations = 200;
    s.epsilon_translation = 2e-5;
    s.epsilon_rotation = 1e-5;
  }
  return s;
}

void expect_near(const Eigen::Isometry3d& found, const Eigen::Isometry3d& truth, double metres,
                 double degrees) {
  const Eigen::Isometry3d e = truth.inverse() * found;
  EXPECT_LT(e.translation().norm(), metres);
  EXPECT_LT(rotation_angle(e) * 180 / 3.14159265, degrees);
}

class EveryCombination : public testing::TestWithParam<Combination> {
 protected:
  // Forward, inverse and from shifted starts.
  void check(const RecordedPair& pair, CorrespondenceKind kind, const RegistrationSettings& settings,
             double shift, double turn, double metres, double degrees) {
    const Eigen::Isometry3d T = pair.T_target_source;
    const auto target = make_target(pair.target, kind);
    const auto source_as_target = make_target(pair.source, kind);
    for (const double sign : {-1.0, 0.0, 1.0}) {
      SCOPED_TRACE(sign);
      const Eigen::Isometry3d start =
          T * se3_exp(sign * twist(shift, -shift / 2, shift / 2, turn / 2, turn, -turn / 2));
      const RegistrationResult forward = register_cloud(pair.source, *target, start, settings);
      EXPECT_TRUE(forward.ok()) << to_string(forward.stop);
      expect_near(forward.T_target_source, T, metres, degrees);
      EXPECT_GT(forward.overlap, 0.3);
      EXPECT_TRUE(forward.degenerate.empty());
      const RegistrationResult inverse =
          register_cloud(pair.target, *source_as_target, start.inverse(), settings);
      EXPECT_TRUE(inverse.ok()) << to_string(inverse.stop);
      expect_near(inverse.T_target_source, T.inverse(), metres, degrees);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Parts, EveryCombination, testing::ValuesIn(combinations),
                         [](const auto& test) { return std::string(test.param.name); });

// A LiDAR's full circle does not fit a pinhole image.
std::vector<Combination> combinations_for_lidar() {
  std::vector<Combination> result;
  for (const Combination& c : combinations)
    if (c.correspondence != CorrespondenceKind::projective) result.push_back(c);
  return result;
}
class EveryLidarCombination : public EveryCombination {};
INSTANTIATE_TEST_SUITE_P(Parts, EveryLidarCombination, testing::ValuesIn(combinations_for_lidar()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(EveryLidarCombination, OutdoorLidarPair) {
  const auto pair = lidar_pair();
  LCMSLAM_SKIP_WITHOUT("registration/small_gicp");
  ASSERT_TRUE(pair);
  RegistrationSettings settings = settings_of(GetParam());
  settings.max_distance = 2;
  settings.min_distance = 0.8;
  settings.noise_floor = 0.05;
  check(*pair, GetParam().correspondence, settings, 0.2, 0.02, 0.15, 1.0);
}

TEST_P(EveryCombination, HandHeldIndoorPairs) {
  const auto recording = Fr1Recording::open();
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  ASSERT_TRUE(recording);
  for (const std::size_t i : {60u, 500u}) {
    SCOPED_TRACE(i);
    RecordedPair pair;
    pair.target = voxel_filtered(geometry_of(recording->cloud(i)), 0.03);
    pair.source = voxel_filtered(geometry_of(recording->cloud(i + 3)), 0.05);
    pair.T_target_source = recording->T_world_camera(i).inverse() * recording->T_world_camera(i + 3);
    check(pair, GetParam().correspondence, settings_of(GetParam()), 0.03, 0.03, 0.05, 2.0);
  }
}

TEST(Registration, WithoutPriorDegenerateDirectionsStay) {
  const Eigen::Isometry3d start = se3_exp(twist(0.03, 0.04, -0.02, 0, 0, 0));
  const RegistrationResult r = register_to_itself(wall(0.02), start);
  ASSERT_TRUE(r.ok());
  EXPECT_NEAR(r.T_target_source.translation().x(), 0, 0.001);
  EXPECT_NEAR(r.T_target_source.translation().y(), 0.04, 1e-6);
  EXPECT_NEAR(r.T_target_source.translation().z(), -0.02, 1e-6);
}

TEST(Registration, AWeakPriorDoesNotPullAGoodRegistration) {
  Prior wrong;
  wrong.T_target_source = se3_exp(twist(0.05, 0.05, -0.05, 0.03, -0.03, 0.03));
  wrong.information = Matrix6d::Identity() / (0.03 * 0.03);
  const RegistrationResult r = register_to_itself(room(), wrong.T_target_source, &wrong);
  expect_near(r.T_target_source, Eigen::Isometry3d::Identity(), 0.004, 0.2);
}

// Pairs of smoothed points outweigh a prior as those of a better camera would, but what fits is judged by the
// noise as it was.
TEST(Registration, ThePriorWeighsLessAgainstSmoothedPoints) {
  constexpr double noise_left = 0.4;
  Prior wrong;
  wrong.T_target_source = se3_exp(twist(0.006, 0.004, -0.005, 0.003, -0.002, 0.004));
  wrong.information = Matrix6d::Identity() / (0.001 * 0.001);
  Prior weaker = wrong;
  weaker.information *= noise_left * noise_left;
  RegistrationSettings settings;
  settings.kernel = KernelKind::none;
  settings.epsilon_translation = settings.epsilon_rotation = 1e-6;
  const auto target = make_target(room(), CorrespondenceKind::kd_tree);
  const auto run = [&](const Prior& prior, double left) {
    return register_cloud(room(0.037), *target, wrong.T_target_source, settings, &prior, nullptr, left);
  };
  const RegistrationResult as_noisy = run(wrong, 1), smoothed = run(wrong, noise_left),
                           better = run(weaker, 1);
  const auto off = [](const RegistrationResult& a, const RegistrationResult& b) {
    return se3_log(a.T_target_source.inverse() * b.T_target_source).norm();
  };
  EXPECT_GT(off(as_noisy, better), 0.001);
  EXPECT_LT(off(smoothed, better), 0.05 * off(as_noisy, better));
  EXPECT_LT((smoothed.covariance - noise_left * noise_left * better.covariance).norm(),
            0.01 * smoothed.covariance.norm());
  EXPECT_EQ(smoothed.inliers, as_noisy.inliers);
  EXPECT_EQ(smoothed.pairs, as_noisy.pairs);
  EXPECT_EQ(smoothed.rms, as_noisy.rms);
}

// Whose noise is said to be smoothed away, but is there: what is told is as unsure as if nobody had said so.
TEST(Registration, NoiseThatWasNotSmoothedAwayIsTold) {
  RegistrationSettings settings;
  settings.kernel = KernelKind::none;
  settings.distance_sigmas = 0;
  settings.noise_floor = 0.001;
  const auto target = make_target(room(0.02), CorrespondenceKind::kd_tree);
  Cloud noisy = room(0.1);
  noisy.sigmas.assign(noisy.size(), 0.01f);
  Random random(1);
  for (Eigen::Vector3f& point : noisy.points)
    for (int axis = 0; axis < 3; ++axis) point[axis] += static_cast<float>(random.normal(0, 0.01));
  const auto told = [&](double left) {
    return register_cloud(noisy, *target, Eigen::Isometry3d::Identity(), settings, nullptr, nullptr, left)
        .covariance.norm();
  };
  EXPECT_NEAR(told(0.3), told(1), 0.2 * told(1));
}

// Noisy copies of a scene: the errors must fit the stated covariance. Independent noise on every
// point, so all of them count; 6 x 40 squared normalised errors have mean 1 +- 0.09.
TEST(Registration, CovarianceIsConsistent) {
  RegistrationSettings settings;
  settings.independent_pairs = 1e9;
  settings.noise_floor = 0.001;
  settings.kernel = KernelKind::none;
  settings.distance_sigmas = 0;
  const Cloud exact = room(0.1);
  const auto target = make_target(room(0.02), CorrespondenceKind::kd_tree);
  double sum = 0;
  constexpr int runs = 40;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    Random random(seed);
    Cloud noisy = exact;
    noisy.sigmas.assign(noisy.size(), 0.01f);
    for (std::size_t i = 0; i < noisy.size(); ++i)
      noisy.points[i] += static_cast<float>(random.normal(0, 0.01)) * noisy.normals[i];
    const RegistrationResult r = register_cloud(noisy, *target, Eigen::Isometry3d::Identity(), settings);
    const Vector6d e = se3_log(r.T_target_source);
    sum += e.dot(r.covariance.inverse() * e) / 6;
  }
  EXPECT_GT(sum / runs, 0.5);
  EXPECT_LT(sum / runs, 1.6);
}

TEST(Registration, RepeatsExactly) {
  RegistrationSettings settings;
  settings.selection = SelectionKind::random;
  settings.selected_points = 300;
  const auto target = make_target(room(), CorrespondenceKind::kd_tree);
  const Eigen::Isometry3d start = se3_exp(twist(0.02, 0.02, 0, 0.01, 0, 0.02));
  const RegistrationResult a = register_cloud(room(), *target, start, settings);
  const RegistrationResult b = register_cloud(room(), *target, start, settings);
  EXPECT_TRUE(a.T_target_source.matrix() == b.T_target_source.matrix());
  EXPECT_TRUE(a.covariance == b.covariance);
  EXPECT_EQ(a.rms, b.rms);
  settings.seed = 2;
  const RegistrationResult c = register_cloud(room(), *target, start, settings);
  EXPECT_FALSE(a.T_target_source.matrix() == c.T_target_source.matrix());
}

TEST(Registration, TwoCloudsFromFarThroughTheFacade) {
  Random random(5);
  for (const auto metric :
       {MetricKind::point_to_point, MetricKind::point_to_plane, MetricKind::plane_to_plane}) {
    const Eigen::Isometry3d T = se3_exp(twist(0.1, -0.1, 0.05, 0.05, 0.05, 0.1));
    const Cloud source(transformed(room(0.037), T.inverse()).points), target(room(0.03).points);
    const auto result = register_clouds(source, target, Eigen::Isometry3d::Identity(), wide_passes(metric));
    EXPECT_TRUE(result.ok()) << to_string(result.stop);
    const Eigen::Isometry3d error = T.inverse() * result.T_target_source;
    EXPECT_LT(error.translation().norm(), 0.01);
    EXPECT_LT(rotation_angle(error), 0.005);
  }
  EXPECT_THROW(register_clouds(room(), room(), Eigen::Isometry3d::Identity(), {}), std::invalid_argument);
}

TEST(Registration, ALookMovesNothingAndAgreesWithTheRun) {
  const KdTreeTarget target(room(0.03));
  const auto run = register_cloud(room(0.037), target, Eigen::Isometry3d::Identity(), {});
  RegistrationSettings settings;
  settings.max_distance = 0.06;
  const auto seen = look(room(0.037), target, run.T_target_source, settings);
  EXPECT_TRUE(seen.T_target_source.matrix() == run.T_target_source.matrix());
  EXPECT_NEAR(seen.overlap, run.overlap, 0.02);
  EXPECT_NEAR(seen.rms.at(0), run.rms.back(), 1e-3);
  EXPECT_EQ(look({}, target, Eigen::Isometry3d::Identity(), settings).stop, StopReason::too_few_pairs);
}

TEST(Registration, IsTheSameInEveryThread) {
  RegistrationSettings settings;
  settings.metric = MetricKind::plane_to_plane;
  settings.selection = SelectionKind::stable;
  settings.selected_points = 500;
  settings.mutual = true;
  const KdTreeTarget target(room(0.04));
  const Eigen::Isometry3d start = se3_exp(twist(0.02, 0.02, 0, 0.01, 0, 0.02));
  std::vector<RegistrationResult> results(8);
  std::vector<std::thread> threads;
  for (auto& result : results)
    threads.emplace_back([&] { result = register_cloud(room(), target, start, settings); });
  for (auto& thread : threads) thread.join();
  for (const auto& result : results) {
    EXPECT_TRUE(result.T_target_source.matrix() == results[0].T_target_source.matrix());
    EXPECT_TRUE(result.covariance == results[0].covariance);
    EXPECT_EQ(result.rms, results[0].rms);
  }
}

class Garbage : public testing::TestWithParam<Combination> {};
INSTANTIATE_TEST_SUITE_P(Parts, Garbage, testing::ValuesIn(combinations),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(Garbage, GivesAStatusAndAFiniteTransform) {
  const RegistrationSettings settings = settings_of(GetParam());
  const Eigen::Isometry3d start = planar_pose(0.01, 0, 0);
  const Cloud empty;
  Cloud not_finite = room();
  for (auto& p : not_finite.points) p.setConstant(std::numeric_limits<float>::quiet_NaN());
  Cloud coincident;
  coincident.points.assign(500, Eigen::Vector3f(0, 0, 2));
  coincident.normals.assign(500, Eigen::Vector3f(0, 0, -1));
  Cloud no_normals = room();
  no_normals.normals.assign(no_normals.size(),
                            Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  const Cloud good = room();
  const std::vector<const Cloud*> clouds = {&empty, &not_finite, &coincident, &no_normals, &good};
  for (const Cloud* source : clouds)
    for (const Cloud* target : clouds) {
      const auto built = make_target(*target, GetParam().correspondence);
      const RegistrationResult r = register_cloud(*source, *built, start, settings);
      EXPECT_TRUE(r.T_target_source.matrix().allFinite());
      EXPECT_TRUE(r.covariance.allFinite());
      const bool hopeless =
          source == &empty || target == &empty || source == &not_finite || target == &not_finite;
      if (hopeless) {
        EXPECT_EQ(r.stop, StopReason::too_few_pairs);
        EXPECT_TRUE(r.T_target_source.matrix() == start.matrix());
      }
    }
}

TEST(Registration, CombinationsThatDoNotExistAreNamed) {
  RegistrationSettings settings;
  settings.solver = SolverKind::svd;
  const auto target = make_target(room(), CorrespondenceKind::kd_tree);
  EXPECT_THROW(register_cloud(room(), *target, Eigen::Isometry3d::Identity(), settings),
               std::invalid_argument);
  settings.metric = MetricKind::point_to_point;
  const Prior prior;
  EXPECT_THROW(register_cloud(room(), *target, Eigen::Isometry3d::Identity(), settings, &prior),
               std::invalid_argument);
}

// 3 cm apart is much for an exact source alone, and little for a target that errs by 5 cm.
TEST(Look, InliersAreJudgedByTheNoiseOfBothClouds) {
  Cloud source = wall(), target = wall();
  for (Eigen::Vector3f& p : source.points) p.x() -= 0.03f;
  source.sigmas.assign(source.size(), 0.001f);
  const auto inliers = [&](float target_sigma) {
    target.sigmas.assign(target.size(), target_sigma);
    RegistrationSettings settings;
    settings.noise_floor = 0.001;
    return look(source, KdTreeTarget(target), Eigen::Isometry3d::Identity(), settings).inliers;
  };
  EXPECT_EQ(inliers(0.001f), 0);
  EXPECT_GT(inliers(0.05f), 300);
}

TEST(Look, NormalsTurnWithTheCloud) {
  const Eigen::Isometry3d T = se3_exp(twist(0.5, -1, 0.3, 0.4, 1.2, 1.5));
  const Cloud source = transformed(room(), T.inverse());
  RegistrationSettings settings;
  settings.max_normal_angle = 0.2;
  EXPECT_GT(look(source, KdTreeTarget(room()), T, settings).overlap, 0.95);
}

}  // namespace
}  // namespace lcmslam

// Four particles at once against one at a time.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include <lcmslam/fastslam/landmarks/landmark_lanes.hpp>
#include <lcmslam/fastslam/proposal.hpp>
#include <lcmslam/fastslam/proposal_equations.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

Eigen::Matrix3d any_covariance(Random& random, double sigma) {
  Eigen::Matrix3d A;
  for (int i = 0; i < 9; ++i) A(i) = random.normal();
  return sigma * sigma * (A * A.transpose() + 0.1 * Eigen::Matrix3d::Identity());
}

Eigen::Isometry3d any_pose(Random& random) {
  Vector6d twist;
  for (int i = 0; i < 6; ++i) twist(i) = random.uniform(-1.5, 1.5);
  return se3_exp(twist);
}

// Landmarks that four particles saw, and what they see of them now. Some are off by many sigma.
struct LanesScene {
  // `mixed`: also measurements in the plane.
  explicit LanesScene(std::uint64_t seed, bool mixed = false, int count = 25) : random(seed) {
    for (auto& T : poses) T = any_pose(random);
    for (int i = 0; i < count; ++i) {
      Measurement z;
      z.value << random.uniform(0.5, 5), random.uniform(-2, 2), random.uniform(0, 2);
      z.covariance = any_covariance(random, 0.02);
      Measurement planar = z;
      if (mixed && i % 4 == 1) planar.kind = MeasurementKind::planar;
      if (mixed && i % 4 == 3) {
        planar.kind = MeasurementKind::range_bearing;
        planar.value = {z.value.head<2>().norm(), std::atan2(z.value.y(), z.value.x()), 0};
      }
      measurements.push_back(planar);
      for (const Eigen::Isometry3d& T : poses) {
        const double off = i % 5 == 0 ? 0.3 : 0.02;
        const Eigen::Vector3d error =
            off * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        compact.emplace_back(T * z.value + error, any_covariance(random, 0.03));
      }
    }
    for (const CompactLandmark& landmark : compact) stored.push_back(&landmark);
    load_landmarks(stored, landmarks);
  }

  Random random;
  Eigen::Isometry3d poses[lane_count];
  std::vector<Measurement> measurements;
  std::vector<CompactLandmark> compact;  // lane_count for each measurement
  std::vector<const CompactLandmark*> stored;
  std::vector<LandmarkLanes> landmarks;
};

void expect_near(const CompactLandmark& a, const CompactLandmark& b) {
  EXPECT_LT((a.mean - b.mean).norm(), 1e-12);
  for (std::size_t f = 0; f < 6; ++f)
    EXPECT_NEAR(a.factors()[f], b.factors()[f], 1e-6 * std::abs(b.factors()[f]) + 1e-9) << f;
}

TEST(LandmarkLanes, LearnAsOneParticleDoes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const LanesScene scene(seed);
    constexpr double added = 1e-6;
    std::vector<LearnedLanes> learned;
    learn_points(scene.measurements, scene.landmarks, scene.poses, added, learned);
    ASSERT_EQ(learned.size(), scene.measurements.size());
    for (std::size_t i = 0; i < learned.size(); ++i)
      for (int lane = 0; lane < lane_count; ++lane) {
        const Measurement& z = scene.measurements[i];
        const Eigen::Isometry3d& T = scene.poses[lane];
        const LandmarkGaussian landmark = *scene.stored[lane_count * i + static_cast<std::size_t>(lane)];
        EXPECT_EQ(scene.landmarks[i].gaussian(lane).mean, landmark.mean);
        EXPECT_EQ(scene.landmarks[i].gaussian(lane).covariance, landmark.covariance);
        const Innovation innovation = innovate(landmark, z, T);
        EXPECT_NEAR(learned[i].distance2[lane], innovation.distance2, 1e-9 * (1 + innovation.distance2));
        EXPECT_NEAR(learned[i].log_peak(lane), innovation.log_peak, 1e-9);
        expect_near(learned[i].updated.landmark(lane), update_landmark(landmark, innovation, z, T, added));
      }
  }
}

TEST(LandmarkLanes, MakeAsOneParticleDoes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const LanesScene scene(seed);
    std::vector<CompactLanes> made;
    make_points(scene.measurements, scene.poses, made);
    ASSERT_EQ(made.size(), scene.measurements.size());
    for (std::size_t i = 0; i < made.size(); ++i)
      for (int lane = 0; lane < lane_count; ++lane)
        expect_near(made[i].landmark(lane), make_landmark(scene.measurements[i], scene.poses[lane]));
  }
}

// Who shares a group, where in it one stands, and which instructions there are: the same bits.
TEST(LandmarkLanes, NeitherNeighboursNorProcessorChangeABit) {
  FastSlamSettings settings;
  const Matrix6d Q = 1e-4 * Matrix6d::Identity();
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    for (const bool planar : {false, true}) {
      SCOPED_TRACE(seed);
      settings.planar = planar;
      const LanesScene scene(seed, true);
      const auto proposal = make_proposal(settings, Q);
      ObservedLanes observed;
      observed.measurements = scene.measurements;
      observed.landmarks = scene.landmarks;
      Random streams[lane_count] = {Random(seed, 0), Random(seed, 1), Random(seed, 2), Random(seed, 3)};
      ProposedPose together[lane_count];
      proposal->propose(scene.poses, observed, streams, lane_count, together);
      std::vector<LearnedLanes> learned;
      learn_points(scene.measurements, scene.landmarks, scene.poses, 1e-6, learned);
      const InstructionSet former = limit_instruction_set(InstructionSet::portable);
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        std::vector<ObservedLandmark> observations;
        std::vector<const CompactLandmark*> same;
        for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
          observations.push_back({scene.measurements[i], *scene.stored[lane_count * i + lane]});
          same.insert(same.end(), lane_count, scene.stored[lane_count * i + lane]);
        }
        Random stream(seed, lane);
        const ProposedPose alone = proposal->propose(scene.poses[lane], observations, stream);
        EXPECT_EQ(alone.T_world_robot.matrix(), together[lane].T_world_robot.matrix());
        EXPECT_EQ(alone.log_weight, together[lane].log_weight);
        const Eigen::Isometry3d& T = scene.poses[lane];
        const Eigen::Isometry3d poses[lane_count] = {T, T, T, T};
        std::vector<LandmarkLanes> landmarks;
        load_landmarks(same, landmarks);
        std::vector<LearnedLanes> repeated;
        learn_points(scene.measurements, landmarks, poses, 1e-6, repeated);
        for (std::size_t i = 0; i < learned.size(); ++i) {
          if (scene.measurements[i].kind != MeasurementKind::point) continue;  // one particle at a time
          const auto k = static_cast<int>(lane);
          EXPECT_EQ(repeated[i].distance2[0], learned[i].distance2[k]);
          EXPECT_EQ(repeated[i].determinant[0], learned[i].determinant[k]);
          EXPECT_TRUE(repeated[i].updated.landmark(0) == learned[i].updated.landmark(k));
        }
      }
      limit_instruction_set(former);
    }
}

// The normal equations against those of one particle, summed from their definitions.
template <int D>
void check_normal_equations() {
  using Space = PoseSpace<D>;
  constexpr double huber = 2;
  const LanesScene scene(3);
  std::vector<LaneSymmetric> weights;
  weigh_points(scene.measurements, scene.landmarks, scene.poses, weights);
  ProposalEquations<D> normal{};
  add_points(scene.measurements, scene.landmarks, weights, scene.poses, huber, normal);
  for (int lane = 0; lane < lane_count; ++lane) {
    typename Space::Matrix information = Space::Matrix::Zero();
    typename Space::Vector gradient = Space::Vector::Zero();
    int beyond = 0;
    for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
      const LandmarkGaussian landmark = scene.landmarks[i].gaussian(lane);
      const Innovation innovation = innovate(landmark, scene.measurements[i], scene.poses[lane]);
      const auto J = Space::residual_jacobian(innovation.predicted);
      const double d = std::sqrt(innovation.distance2), weight = d > huber ? huber / d : 1;
      beyond += d > huber;
      information += weight * J.transpose() * innovation.inverse * J;
      gradient += weight * J.transpose() * innovation.inverse * innovation.residual;
    }
    EXPECT_GT(beyond, 0);
    for (std::size_t i = 0; i < D; ++i) {
      const auto row = static_cast<int>(i);
      EXPECT_NEAR(normal.gradient[i][lane], gradient(row), 1e-9 * gradient.norm());
      for (std::size_t j = 0; j <= i; ++j)
        EXPECT_NEAR(normal.information[i][j][lane], information(row, static_cast<int>(j)),
                    1e-9 * information.norm());
    }
    LaneCholesky<D> root;
    typename LaneCholesky<D>::Vector mean{};
    descend(normal, root, mean);
    const typename Space::Vector step = information.ldlt().solve(gradient);
    for (std::size_t i = 0; i < D; ++i)
      EXPECT_NEAR(mean[i][lane], -step(static_cast<int>(i)), 1e-9 * (1 + step.norm()));
    EXPECT_NEAR(root.half_log_determinant(lane), 0.5 * std::log(information.determinant()), 1e-9);
  }
}

TEST(ProposalEquations, AreThoseOfEachParticle) {
  check_normal_equations<3>();
  check_normal_equations<6>();
}

}  // namespace
}  // namespace lcmslam

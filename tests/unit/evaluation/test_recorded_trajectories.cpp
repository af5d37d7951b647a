// ATE of published trajectories against a second computation, written from the definition: brute-force
// association and a rotation found by Horn's unit quaternion instead of the SVD.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <tuple>

#include "evaluation/trajectory_error.hpp"
#include "unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

using Points = std::vector<Eigen::Vector3d>;

void brute_force_pairs(const Trajectory& truth, const Trajectory& estimate, Points& p, Points& q) {
  std::vector<std::tuple<Utime, Utime, Utime>> all;
  for (const auto& t : truth) {
    for (const auto& e : estimate) {
      const Utime difference = std::abs(t.utime - e.utime);
      if (difference < 20'000) all.emplace_back(difference, t.utime, e.utime);
    }
  }
  std::sort(all.begin(), all.end());
  std::vector<Utime> used_t, used_e;
  const auto position = [](const Trajectory& trajectory, Utime utime) {
    const auto found = std::find_if(trajectory.begin(), trajectory.end(),
                                    [&](const StampedPose& pose) { return pose.utime == utime; });
    return Eigen::Vector3d(found->T_world_body.translation());
  };
  for (const auto& [difference, t, e] : all) {
    if (std::find(used_t.begin(), used_t.end(), t) != used_t.end()) continue;
    if (std::find(used_e.begin(), used_e.end(), e) != used_e.end()) continue;
    used_t.push_back(t);
    used_e.push_back(e);
    p.push_back(position(truth, t));
    q.push_back(position(estimate, e));
  }
}

// Horn 1987: the quaternion is the eigenvector of the largest eigenvalue of N.
double ate_by_definition(const Trajectory& truth, const Trajectory& estimate, std::size_t& count) {
  Points p, q;
  brute_force_pairs(truth, estimate, p, q);
  count = p.size();
  Eigen::Vector3d p0(0, 0, 0), q0(0, 0, 0);
  for (std::size_t i = 0; i < p.size(); ++i) p0 += p[i], q0 += q[i];
  p0 /= static_cast<double>(count);
  q0 /= static_cast<double>(count);
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < p.size(); ++i) S += (q[i] - q0) * (p[i] - p0).transpose();
  Eigen::Matrix4d N;
  N << S.trace(), S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0),                   //
      S(1, 2) - S(2, 1), S(0, 0) - S(1, 1) - S(2, 2), S(0, 1) + S(1, 0), S(2, 0) + S(0, 2),  //
      S(2, 0) - S(0, 2), S(0, 1) + S(1, 0), S(1, 1) - S(0, 0) - S(2, 2), S(1, 2) + S(2, 1),  //
      S(0, 1) - S(1, 0), S(2, 0) + S(0, 2), S(1, 2) + S(2, 1), S(2, 2) - S(0, 0) - S(1, 1);
  const Eigen::Vector4d v = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(N).eigenvectors().col(3);
  const Eigen::Quaterniond rotation(v[0], v[1], v[2], v[3]);
  double squares = 0;
  for (std::size_t i = 0; i < p.size(); ++i) squares += (rotation * (q[i] - q0) - (p[i] - p0)).squaredNorm();
  return std::sqrt(squares / static_cast<double>(count));
}

void check(const std::string& truth_name, const std::string& estimate_name) {
  const auto folder = testing::data_folder("trajectories");
  if (!std::filesystem::exists(folder / truth_name)) {
    GTEST_SKIP() << (folder / truth_name) << " is not there: set LCMSLAM_DATA to the recordings' folder";
  }
  const Trajectory truth = read_tum(folder / truth_name);
  const Trajectory estimate = read_tum(folder / estimate_name);
  const TrajectoryReport report = evaluate(truth, estimate);
  std::size_t count = 0;
  const double rmse = ate_by_definition(truth, estimate, count);
  EXPECT_EQ(report.matched_poses, count);
  EXPECT_NEAR(report.absolute.translation.rmse, rmse, 1e-6);
  std::cout << estimate_name << ": ATE " << report.absolute.translation.rmse << " m (definition " << rmse
            << "), " << count << " matches, RPE " << report.per_second.translation.rmse << " m and "
            << report.per_second.rotation.rmse << " rad per second\n";
}

TEST(RecordedTrajectories, FreiburgXyzRgbdSlam) {
  check("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam.txt");
}

TEST(RecordedTrajectories, FreiburgXyzRgbdSlamWithDrift) {
  check("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam_drift.txt");
}

TEST(RecordedTrajectories, FreiburgDeskOrbSlam) {
  check("fr2_desk_groundtruth.txt", "fr2_desk_ORB.txt");
}

// A monocular estimate has no scale: sim3 must beat se3 by far.
TEST(RecordedTrajectories, MonocularKeyframesNeedScale) {
  const auto folder = testing::data_folder("trajectories");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there: set LCMSLAM_DATA";
  const Trajectory truth = read_tum(folder / "fr2_desk_groundtruth.txt");
  const Trajectory estimate = read_tum(folder / "fr2_desk_ORB_kf_mono.txt");
  EvaluationSettings settings;
  const double se3 = evaluate(truth, estimate, settings).absolute.translation.rmse;
  settings.alignment = Alignment::sim3;
  const TrajectoryReport sim3 = evaluate(truth, estimate, settings);
  EXPECT_LT(sim3.absolute.translation.rmse, 0.2 * se3);
  EXPECT_GT(std::abs(sim3.alignment.scale - 1), 0.05);
  std::cout << "mono: se3 " << se3 << " m, sim3 " << sim3.absolute.translation.rmse << " m at scale "
            << sim3.alignment.scale << "\n";
}

}  // namespace
}  // namespace lcmslam

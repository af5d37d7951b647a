#pragma once
// Gauss-Newton on the poses of four particles at once: the proposal's inner loops.

#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_lanes.hpp>

namespace lcmslam {

/// Information and gradient of four pose perturbations of D components (PoseSpace).
template <int D>
struct ProposalEquations {
  using Vector = typename LaneCholesky<D>::Vector;
  typename LaneCholesky<D>::Matrix information;  // lower triangle
  Vector gradient;
};

/// S^-1 of every point measurement from T_world_robot[lane_count]; the others' entries are undefined.
void weigh_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                  const Eigen::Isometry3d* T_world_robot, std::vector<LaneSymmetric>& weights);

/// Adds J^T W J and J^T W r of every point measurement, r = z - h(m) from T_world_robot[lane_count] and W =
/// S^-1, less where Huber's rho with the width `huber` (sigma) says so.
void add_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                const std::vector<LaneSymmetric>& weights, const Eigen::Isometry3d* T_world_robot,
                double huber, ProposalEquations<3>& normal);
void add_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                const std::vector<LaneSymmetric>& weights, const Eigen::Isometry3d* T_world_robot,
                double huber, ProposalEquations<6>& normal);

/// One step: factors the information, mean -= information^-1 gradient.
void descend(const ProposalEquations<3>& normal, LaneCholesky<3>& root, LaneCholesky<3>::Vector& mean);
void descend(const ProposalEquations<6>& normal, LaneCholesky<6>& root, LaneCholesky<6>::Vector& mean);

}  // namespace lcmslam

#include <lcmslam/fastslam/proposal_equations.hpp>

#include <lcmslam/parallel/instruction_set.hpp>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // see lanes.hpp
#endif

namespace lcmslam {
namespace {

// Adds PoseSpace<D>::normal_matrix(W, h) and PoseSpace<D>::wrench(g, h).
LCMSLAM_LANES void add(const LaneSymmetric& W, const LaneVector& g, const LaneVector& h,
                       ProposalEquations<3>& sum) {
  const Lanes x = W.yx * h.x - W.xx * h.y, y = W.yy * h.x - W.yx * h.y;
  auto& N = sum.information;
  N[0][0] += W.xx;
  N[1][0] += W.yx;
  N[1][1] += W.yy;
  N[2][0] += x;
  N[2][1] += y;
  N[2][2] += h.x * y - h.y * x;
  sum.gradient[0] += g.x;
  sum.gradient[1] += g.y;
  sum.gradient[2] += h.x * g.y - h.y * g.x;
}

LCMSLAM_LANES void add(const LaneSymmetric& W, const LaneVector& g, const LaneVector& h,
                       ProposalEquations<6>& sum) {
  const LaneMatrix columns_of_W = columns(W);
  const LaneMatrix B{cross(h, columns_of_W.x), cross(h, columns_of_W.y), cross(h, columns_of_W.z)};
  const LaneMatrix rows = transposed(B);
  const LaneVector first = cross(h, rows.x), second = cross(h, rows.y), third = cross(h, rows.z);
  const LaneVector torque = cross(h, g);
  auto& N = sum.information;
  N[0][0] += W.xx;
  N[1][0] += W.yx;
  N[1][1] += W.yy;
  N[2][0] += W.zx;
  N[2][1] += W.zy;
  N[2][2] += W.zz;
  const LaneVector* const turned[3] = {&rows.x, &rows.y, &rows.z};
  for (std::size_t i = 0; i < 3; ++i) {
    N[3 + i][0] += turned[i]->x;
    N[3 + i][1] += turned[i]->y;
    N[3 + i][2] += turned[i]->z;
  }
  N[3][3] += first.x;
  N[4][3] += first.y;
  N[5][3] += first.z;
  N[4][4] += second.y;
  N[5][4] += second.z;
  N[5][5] += third.z;
  sum.gradient[0] += g.x;
  sum.gradient[1] += g.y;
  sum.gradient[2] += g.z;
  sum.gradient[3] += torque.x;
  sum.gradient[4] += torque.y;
  sum.gradient[5] += torque.z;
}

// Huber's weight: 1 within the width, which nearly all are.
LCMSLAM_LANES Lanes robust_weight(const Lanes& distance2, double width) {
  const LaneMask beyond = distance2 > width * width;
  if (!(beyond[0] | beyond[1] | beyond[2] | beyond[3])) return all_lanes(1);
  return chosen(beyond, width / square_root(distance2), all_lanes(1));
}

template <int D>
LCMSLAM_LANES void add_all(const Measurement* z, const LandmarkLanes* landmarks, const LaneSymmetric* weights,
                           int count, const Eigen::Isometry3d* poses, double huber,
                           ProposalEquations<D>& normal) {
  const LanePose T = each_lane_pose(poses);
  const LaneMatrix R_robot_world = transposed(T.R);
  ProposalEquations<D> sum = normal;
  for (int i = 0; i < count; ++i) {
    if (z[i].kind != MeasurementKind::point) continue;
    const LaneVector h = R_robot_world * (landmarks[i].mean - T.t);
    const LaneVector residual = all_lanes(z[i].value) - h;
    const LaneVector weighted = weights[i] * residual;
    const Lanes robust = robust_weight(dot(residual, weighted), huber);
    add(robust * weights[i], robust * weighted, h, sum);
  }
  normal = sum;
}

template <int D>
LCMSLAM_LANES void descend_by(const ProposalEquations<D>& normal, LaneCholesky<D>& root,
                              typename LaneCholesky<D>::Vector& mean) {
  LaneCholesky<D> factors;
  factors.factor(normal.information);
  typename LaneCholesky<D>::Vector step = normal.gradient;
  factors.solve(step);
  for (std::size_t i = 0; i < D; ++i) mean[i] -= step[i];
  root = factors;
}

LCMSLAM_VECTORISED(weigh_all,
                   (const Measurement* z, const LandmarkLanes* landmarks, int count,
                    const Eigen::Isometry3d* poses, LaneSymmetric* weights),
                   (z, landmarks, count, poses, weights)) {
  const LaneMatrix R_robot_world = transposed(each_lane_pose(poses).R);
  for (int i = 0; i < count; ++i)
    if (z[i].kind == MeasurementKind::point)
      weights[i] =
          inverted(sandwiched(R_robot_world, landmarks[i].covariance) + all_lanes(z[i].covariance)).inverse;
}

LCMSLAM_VECTORISED(add_all_3,
                   (const Measurement* z, const LandmarkLanes* landmarks, const LaneSymmetric* weights,
                    int count, const Eigen::Isometry3d* poses, double huber, ProposalEquations<3>& normal),
                   (z, landmarks, weights, count, poses, huber, normal)) {
  add_all<3>(z, landmarks, weights, count, poses, huber, normal);
}

LCMSLAM_VECTORISED(add_all_6,
                   (const Measurement* z, const LandmarkLanes* landmarks, const LaneSymmetric* weights,
                    int count, const Eigen::Isometry3d* poses, double huber, ProposalEquations<6>& normal),
                   (z, landmarks, weights, count, poses, huber, normal)) {
  add_all<6>(z, landmarks, weights, count, poses, huber, normal);
}

LCMSLAM_VECTORISED(descend_3,
                   (const ProposalEquations<3>& normal, LaneCholesky<3>& root, LaneCholesky<3>::Vector& mean),
                   (normal, root, mean)) {
  descend_by<3>(normal, root, mean);
}

LCMSLAM_VECTORISED(descend_6,
                   (const ProposalEquations<6>& normal, LaneCholesky<6>& root, LaneCholesky<6>::Vector& mean),
                   (normal, root, mean)) {
  descend_by<6>(normal, root, mean);
}

}  // namespace

void weigh_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                  const Eigen::Isometry3d* T_world_robot, std::vector<LaneSymmetric>& weights) {
  weights.resize(landmarks.size());
  weigh_all(measurements.data(), landmarks.data(), static_cast<int>(landmarks.size()), T_world_robot,
            weights.data());
}

void add_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                const std::vector<LaneSymmetric>& weights, const Eigen::Isometry3d* T_world_robot,
                double huber, ProposalEquations<3>& normal) {
  add_all_3(measurements.data(), landmarks.data(), weights.data(), static_cast<int>(landmarks.size()),
            T_world_robot, huber, normal);
}

void add_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                const std::vector<LaneSymmetric>& weights, const Eigen::Isometry3d* T_world_robot,
                double huber, ProposalEquations<6>& normal) {
  add_all_6(measurements.data(), landmarks.data(), weights.data(), static_cast<int>(landmarks.size()),
            T_world_robot, huber, normal);
}

void descend(const ProposalEquations<3>& normal, LaneCholesky<3>& root, LaneCholesky<3>::Vector& mean) {
  descend_3(normal, root, mean);
}

void descend(const ProposalEquations<6>& normal, LaneCholesky<6>& root, LaneCholesky<6>::Vector& mean) {
  descend_6(normal, root, mean);
}

}  // namespace lcmslam

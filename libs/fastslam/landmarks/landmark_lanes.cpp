#include <lcmslam/fastslam/landmarks/landmark_lanes.hpp>

#include <cmath>

#include <lcmslam/parallel/instruction_set.hpp>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // see lanes.hpp
#endif

namespace lcmslam {
namespace {

constexpr double two_pi = 6.283185307179586;

// L D L^T in floats: the constructor of CompactLandmark for four.
LCMSLAM_LANES CompactLanes compact(const LaneVector& mean, const LaneSymmetric& P) {
  const Lanes least = all_lanes(CompactLandmark::least_part);
  const Lanes scale0 = 1. / P.xx, l10 = P.yx * scale0, l20 = P.zx * scale0;
  const Lanes d1 = larger(P.yy - l10 * P.yx, least * P.yy);
  const Lanes m21 = P.zy - l20 * P.yx, l21 = m21 / d1;
  const Lanes d2 = larger(P.zz - l20 * P.zx - l21 * m21, least * P.zz);
  using Floats = CompactLanes::Floats;
  return {mean,
          {__builtin_convertvector(P.xx, Floats), __builtin_convertvector(d1, Floats),
           __builtin_convertvector(d2, Floats), __builtin_convertvector(l10, Floats),
           __builtin_convertvector(l20, Floats), __builtin_convertvector(l21, Floats)}};
}

LCMSLAM_LANES Lanes factor(const CompactLandmark* const* stored, std::size_t f) {
  return each_lane([stored, f](int lane) { return static_cast<double>(stored[lane]->factors()[f]); });
}

// CompactLandmark::covariance() for four.
LCMSLAM_LANES LandmarkLanes expanded(const CompactLandmark* const* stored) {
  const Lanes d0 = factor(stored, 0), d1 = factor(stored, 1), d2 = factor(stored, 2);
  const Lanes l10 = factor(stored, 3), l20 = factor(stored, 4), l21 = factor(stored, 5);
  const Lanes p10 = l10 * d0, p20 = l20 * d0, m21 = l21 * d1;
  return {each_lane_vector([stored](int lane) { return stored[lane]->mean.data(); }),
          {d0, p10, p20, l10 * p10 + d1, l20 * p10 + m21, l20 * p20 + l21 * m21 + d2}};
}

// With Q = R R_z R^T: S = P + Q, m + P S^-1 r, and P S^-1 Q for P - P S^-1 P as in landmark_filter.cpp.
LCMSLAM_LANES LearnedLanes learn_point(const Measurement& z, const LandmarkLanes& landmark, const LanePose& T,
                                       const Lanes& added) {
  const LaneSymmetric Q = sandwiched(T.R, all_lanes(z.covariance));
  const LaneInverse S = inverted(landmark.covariance + Q);
  const LaneVector residual = T.R * all_lanes(z.value) + T.t - landmark.mean;
  const LaneVector weighted = S.inverse * residual;
  const LaneMatrix P = columns(landmark.covariance);
  LaneSymmetric kept = symmetric_product(P * columns(S.inverse), columns(Q));
  kept.xx += added;
  kept.yy += added;
  kept.zz += added;
  return {dot(residual, weighted), S.determinant, compact(landmark.mean + P * weighted, kept)};
}

LCMSLAM_VECTORISED(load_all, (const CompactLandmark* const* stored, int count, LandmarkLanes* landmarks),
                   (stored, count, landmarks)) {
  for (int i = 0; i < count; ++i) landmarks[i] = expanded(stored + lane_count * i);
}

LCMSLAM_VECTORISED(learn_all,
                   (const Measurement* z, const LandmarkLanes* landmarks, int count,
                    const Eigen::Isometry3d* poses, double added, LearnedLanes* learned),
                   (z, landmarks, count, poses, added, learned)) {
  const LanePose T = each_lane_pose(poses);
  for (int i = 0; i < count; ++i)
    if (z[i].kind == MeasurementKind::point)
      learned[i] = learn_point(z[i], landmarks[i], T, all_lanes(added));
}

LCMSLAM_VECTORISED(make_all,
                   (const Measurement* z, int count, const Eigen::Isometry3d* poses, CompactLanes* made),
                   (z, count, poses, made)) {
  const LanePose T = each_lane_pose(poses);
  for (int i = 0; i < count; ++i)
    if (z[i].kind == MeasurementKind::point)
      made[i] = compact(T.R * all_lanes(z[i].value) + T.t, sandwiched(T.R, all_lanes(z[i].covariance)));
}

}  // namespace

LandmarkGaussian LandmarkLanes::gaussian(int k) const {
  const LaneSymmetric& P = covariance;
  LandmarkGaussian result;
  result.mean << mean.x[k], mean.y[k], mean.z[k];
  result.covariance << P.xx[k], P.yx[k], P.zx[k], P.yx[k], P.yy[k], P.zy[k], P.zx[k], P.zy[k], P.zz[k];
  return result;
}

CompactLandmark CompactLanes::landmark(int k) const {
  return {{mean.x[k], mean.y[k], mean.z[k]},
          CompactLandmark::Factors{factors[0][k], factors[1][k], factors[2][k], factors[3][k], factors[4][k],
                                   factors[5][k]}};
}

double LearnedLanes::log_peak(int lane) const {
  return -0.5 * std::log(two_pi * two_pi * two_pi * determinant[lane]);
}

void load_landmarks(const std::vector<const CompactLandmark*>& stored,
                    std::vector<LandmarkLanes>& landmarks) {
  landmarks.resize(stored.size() / lane_count);
  load_all(stored.data(), static_cast<int>(landmarks.size()), landmarks.data());
}

void learn_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                  const Eigen::Isometry3d* T_world_robot, double added_variance,
                  std::vector<LearnedLanes>& learned) {
  learned.resize(landmarks.size());
  learn_all(measurements.data(), landmarks.data(), static_cast<int>(landmarks.size()), T_world_robot,
            added_variance, learned.data());
}

void make_points(const std::vector<Measurement>& measurements, const Eigen::Isometry3d* T_world_robot,
                 std::vector<CompactLanes>& made) {
  made.resize(measurements.size());
  make_all(measurements.data(), static_cast<int>(measurements.size()), T_world_robot, made.data());
}

}  // namespace lcmslam

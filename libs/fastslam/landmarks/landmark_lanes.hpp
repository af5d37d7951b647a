#pragma once
// The landmark filter for 3-D points, four particles at once: what landmark_filter.hpp does one by one. Other
// measurements (planar ones, bearings) are few, and go that way.

#include <vector>

#include <lcmslam/fastslam/landmarks/lanes.hpp>
#include <lcmslam/fastslam/landmarks/particle_map.hpp>

namespace lcmslam {

/// One landmark in four particles' maps, world.
struct LandmarkLanes {
  LaneVector mean;           ///< m
  LaneSymmetric covariance;  ///< m^2

  LandmarkGaussian gaussian(int lane) const;
};

/// The same as CompactLandmark keeps it.
struct CompactLanes {
  using Floats = float __attribute__((vector_size(16)));
  LaneVector mean;
  std::array<Floats, 6> factors;

  CompactLandmark landmark(int lane) const;
};

/// What a measurement says of a landmark in four particles (compare Innovation), and the landmark if they
/// believe it.
struct LearnedLanes {
  Lanes distance2;    ///< d^2 = residual^T S^-1 residual
  Lanes determinant;  ///< |S|
  CompactLanes updated;

  double log_peak(int lane) const;  ///< log |2 pi S|^-1/2
};

/// stored[lane_count * i + lane] -> landmarks[i].
void load_landmarks(const std::vector<const CompactLandmark*>& stored, std::vector<LandmarkLanes>& landmarks);

/// Kalman update of every landmark that has a point measurement, as innovate() and update_landmark() from
/// T_world_robot[lane_count], in world coordinates, where less is to be rotated. The others' entries are
/// undefined.
void learn_points(const std::vector<Measurement>& measurements, const std::vector<LandmarkLanes>& landmarks,
                  const Eigen::Isometry3d* T_world_robot, double added_variance,
                  std::vector<LearnedLanes>& learned);

/// make_landmark() of every point measurement; the others' entries are undefined.
void make_points(const std::vector<Measurement>& measurements, const Eigen::Isometry3d* T_world_robot,
                 std::vector<CompactLanes>& made);

}  // namespace lcmslam

#pragma once
// What the mapper found, as messages. Whoever publishes them adds times, counts and revision.

#include <optional>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/graph_covariance_t.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/icp_report_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {

/// `T_step_depth`: the robot's motion from the step's moment to `depth_utime`, of which the pose is told.
/// `clock_error`: how far the robot moves while the depth image's stamp may be wrong, m, rad, body frame.
pose_estimate_t icp_pose(const DenseMapper::Step& step, Utime depth_utime,
                         const Eigen::Isometry3d& T_step_depth, const Vector6d& clock_error);

/// The pose's two parts, as `pose` otherwise: in the local frame, which never jumps, with the covariance
/// against the map in sight; and where that frame lies in the map, with the pose's covariance as seen from
/// the local frame's origin.
pose_estimate_t icp_local_pose(const pose_estimate_t& pose, const DenseMapper::Step& step,
                               const Eigen::Isometry3d& T_step_depth, const std::string& local_frame);
pose_estimate_t icp_correction(const pose_estimate_t& pose, const DenseMapper::Step& step,
                               const std::string& local_frame);

/// `correction`: from where odometry alone would have led; without it unknown (NaN).
icp_report_t icp_report(const DenseMapper::Step& step, const DenseMapperSettings& settings,
                        const std::optional<Eigen::Isometry3d>& correction);

/// The whole graph, for GraphTeller.
graph_t icp_graph(const KeyframeGraph& graph);

/// Of the nodes that `told`, made of the mapper's graph as it stands, names.
graph_covariance_t icp_graph_covariance(const DenseMapper& mapper, const graph_t& told,
                                        const Eigen::Isometry3d& T_robot_camera);

}  // namespace lcmslam

#pragma once
// What the mapper found, as messages. Whoever publishes them adds times, counts and revision.

#include <optional>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/icp_report_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {

/// `T_step_depth`: the robot's motion from the step's moment to `depth_utime`, of which the pose is told.
pose_estimate_t icp_pose(const DenseMapper::Step& step, Utime depth_utime,
                         const Eigen::Isometry3d& T_step_depth);

/// `correction`: from where odometry alone would have led; without it unknown (NaN).
icp_report_t icp_report(const DenseMapper::Step& step, const DenseMapperSettings& settings,
                        const std::optional<Eigen::Isometry3d>& correction);

/// The whole graph, for GraphTeller.
graph_t icp_graph(const KeyframeGraph& graph);

}  // namespace lcmslam

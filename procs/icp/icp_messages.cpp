#include "procs/icp/icp_messages.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>

namespace lcmslam {
namespace {

std::int8_t wire_status(MappingStatus status) {
  switch (status) {
    case MappingStatus::initialising:
      return pose_estimate_t::INITIALISING;
    case MappingStatus::tracking:
      return pose_estimate_t::TRACKING;
    case MappingStatus::degraded:
      return pose_estimate_t::DEGRADED;
    case MappingStatus::lost:
      return pose_estimate_t::LOST;
  }
  return pose_estimate_t::LOST;
}

std::int8_t wire_reason(StopReason reason) {
  switch (reason) {
    case StopReason::converged:
      return icp_report_t::CONVERGED;
    case StopReason::max_iterations:
      return icp_report_t::MAX_ITERATIONS;
    case StopReason::too_few_pairs:
      return icp_report_t::TOO_FEW_POINTS;
    case StopReason::degenerate:
      return icp_report_t::DEGENERATE;
  }
  return icp_report_t::DIVERGED;
}

std::string degenerate_directions(const RegistrationResult& result) {
  std::string text;
  for (const std::string& name : degenerate_names(result))
    text += (text.empty() ? "degenerate: " : ", ") + name;
  return text;
}

std::string describe(const DenseMapperSettings& settings) {
  const RegistrationSettings& s = settings.fine;
  if (settings.variant != VariantKind::modern)
    return to_string(settings.variant) + ", growing cloud, " +
           to_string(settings.thesis.icp.registration.solver);
  return to_string(s.metric) + ", " + to_string(settings.correspondence) + ", " + to_string(s.solver);
}

/// Standard deviation of one axis of a 3 x 3 covariance, on average.
float sigma(const Eigen::Matrix3d& covariance) {
  return static_cast<float>(std::sqrt(covariance.trace() / 3));
}

}  // namespace

pose_estimate_t icp_pose(const DenseMapper::Step& step, Utime depth_utime,
                         const Eigen::Isometry3d& T_step_depth, const Vector6d& clock_error) {
  pose_estimate_t pose = make_pose_estimate(depth_utime, step.T_world_robot * T_step_depth,
                                            step.map_covariance + clock_error * clock_error.transpose());
  pose.status =
      step.relocalised ? static_cast<std::int8_t>(pose_estimate_t::RELOCALISED) : wire_status(step.status);
  pose.quality = static_cast<float>(step.quality);
  pose.inliers = step.registration.inliers;
  pose.detail = degenerate_directions(step.registration);
  return pose;
}

pose_estimate_t icp_local_pose(const pose_estimate_t& pose, const DenseMapper::Step& step,
                               const Eigen::Isometry3d& T_step_depth, const std::string& local_frame) {
  const pose_estimate_t part =
      make_pose_estimate(pose.utime, step.T_local_robot * T_step_depth, step.local_covariance);
  pose_estimate_t local = pose;
  local.frame = local_frame;
  local.T_map_robot = part.T_map_robot;
  std::copy(std::begin(part.covariance), std::end(part.covariance), local.covariance);
  return local;
}

pose_estimate_t icp_correction(const pose_estimate_t& pose, const DenseMapper::Step& step,
                               const std::string& local_frame) {
  const Matrix6d A = adjoint(step.T_local_robot);
  const pose_estimate_t part =
      make_pose_estimate(pose.utime, step.T_world_local, A * step.map_covariance * A.transpose());
  pose_estimate_t correction = pose;
  correction.child_frame = local_frame;
  correction.T_map_robot = part.T_map_robot;
  std::copy(std::begin(part.covariance), std::end(part.covariance), correction.covariance);
  return correction;
}

icp_report_t icp_report(const DenseMapper::Step& step, const DenseMapperSettings& settings,
                        const std::optional<Eigen::Isometry3d>& correction) {
  const RegistrationResult& registration = step.registration;
  icp_report_t report;
  report.variant = describe(settings);
  for (const double rms : registration.rms) report.rms.push_back(static_cast<float>(rms));
  report.n_iterations = static_cast<int32_t>(report.rms.size());
  report.inliers = registration.inliers;
  report.overlap = static_cast<float>(registration.overlap);
  report.stop_reason = wire_reason(registration.stop);
  report.stop_text = to_string(registration.stop);
  report.correction_trans = report.correction_rot = std::numeric_limits<float>::quiet_NaN();
  if (correction) {
    report.correction_trans = static_cast<float>(correction->translation().norm());
    report.correction_rot = static_cast<float>(rotation_angle(*correction));
  }
  for (int i = 0; i < 6; ++i) report.observability[i] = static_cast<float>(registration.observability(i));
  return report;
}

graph_t icp_graph(const KeyframeGraph& graph) {
  graph_t message{};  // change 0: all of it
  message.frame = "map";
  for (const KeyframeGraph::Node& n : graph.nodes()) {
    graph_node_t node;
    node.keyframe = n.id;
    node.keyframe_utime = n.utime;
    node.T_map_camera = to_message(n.T_world_camera);
    message.nodes.push_back(node);
  }
  message.n_nodes = static_cast<int32_t>(message.nodes.size());
  for (const GraphEdge& e : graph.edges()) {
    graph_edge_t edge;
    edge.from_node = graph.nodes()[static_cast<std::size_t>(e.from)].id;
    edge.to_node = graph.nodes()[static_cast<std::size_t>(e.to)].id;
    edge.kind = static_cast<std::int8_t>(e.kind);
    edge.T_from_to = to_message(e.T_from_to.T);
    edge.sigma_trans = sigma(e.T_from_to.covariance.topLeftCorner<3, 3>());
    edge.sigma_rot = sigma(e.T_from_to.covariance.bottomRightCorner<3, 3>());
    edge.error = static_cast<float>(e.error);
    message.edges.push_back(edge);
  }
  message.n_edges = static_cast<int32_t>(message.edges.size());
  return message;
}

graph_covariance_t icp_graph_covariance(const DenseMapper& mapper, const graph_t& told,
                                        const Eigen::Isometry3d& T_robot_camera) {
  graph_covariance_t message{};
  message.utime = told.utime;
  message.frame = told.frame;
  std::map<std::int32_t, const KeyframeGraph::Node*> nodes;
  for (const KeyframeGraph::Node& n : mapper.graph().nodes()) nodes[n.id] = &n;
  for (const graph_node_t& node : told.nodes)
    message.nodes.push_back(
        to_message(node.keyframe, mapper.node_covariance(*nodes.at(node.keyframe), T_robot_camera)));
  message.n_nodes = static_cast<int32_t>(message.nodes.size());
  return message;
}

}  // namespace lcmslam

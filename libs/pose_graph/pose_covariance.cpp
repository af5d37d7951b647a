#include <lcmslam/pose_graph/pose_covariance.hpp>

#include <lcmslam/pose_graph/graph_marginals.hpp>

namespace lcmslam {

std::vector<Matrix6d> pose_covariances(const PoseGraph& graph, const PoseGraphSettings& settings,
                                       const ErrorFactors& factors) {
  std::vector<Matrix6d> covariances(graph.poses.size(), Matrix6d::Zero());
  if (graph.poses.size() < 2) return covariances;
  const auto marginals = GraphMarginals::of(graph, settings, factors);
  if (!marginals) return {};
  for (std::size_t i = 1; i < covariances.size(); ++i) {
    const auto node = static_cast<int>(i);
    const GraphMarginals::Shared shared = marginals->shared(node);
    covariances[i] = marginals->block(node, node) + shared * shared.transpose();
  }
  return covariances;
}

}  // namespace lcmslam

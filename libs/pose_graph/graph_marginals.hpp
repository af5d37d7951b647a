#pragma once
// What a graph's measurements leave open of its poses, after
//
//   H = sum J_ij^T R_ij^-1 J_ij + sum A^T R_i^-1 A,   G = H^-1 (sum J_ij^T R_ij^-1 b_ij + sum A^T R_i^-1 A
//   b_i)
//
// with R what an edge or the ground errs by and b the errors that all edges share, and all of the ground: the
// mount's (mount_error.hpp). Edges share by how much they are too long and bent with those of their stretch
// of the way, as what a camera errs by lasts as long as what it sees is alike. Only the entries of H^-1 that
// its sparse factor has are computed (Takahashi, Fagan and Chin 1973; Erisman and Tinney 1975), so the cost
// is that of the factorisation.

#include <Eigen/SparseCore>
#include <cstdint>
#include <optional>

#include <lcmslam/pose_graph/error_factors.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

/// Whether edges err each on their own.
enum class EdgeErrors : std::uint8_t {
  independent,
  /// A node's edges to those before it see the same surfaces with the same cloud, and err alike: those along
  /// the way count together as one, and so do its loops (covariance intersection with equal weights, Julier
  /// and Uhlmann 1997, which holds whatever the correlation).
  alike
};

class GraphMarginals {
 public:
  /// One column for one sigma of each error.
  struct Shared {
    Eigen::Matrix<double, 6, Eigen::Dynamic> by_edges;
    Matrix6d by_mount;
  };

  /// Nothing when the edges do not tie all nodes to the first, or there is but one.
  static std::optional<GraphMarginals> of(const PoseGraph& graph, const PoseGraphSettings& settings,
                                          const ErrorFactors& factors,
                                          EdgeErrors errors = EdgeErrors::independent);

  /// Block (i, j) of H^-1, i and j the same or joined by an edge; zero for the first node.
  Matrix6d block(int i, int j) const;
  /// Rows of G; zero for the first node.
  Shared shared(int i) const;

 private:
  GraphMarginals() = default;
  double at(int row, int column) const;

  // (L D L^T)^-1 where L has entries: below its diagonal, and on it.
  Eigen::SparseMatrix<double> inverse_;
  Eigen::VectorXd diagonal_;
  Eigen::VectorXi place_;   // of an unknown in the factor
  Eigen::MatrixXd shared_;  // the mount's columns first
};

}  // namespace lcmslam

#include <lcmslam/pose_graph/pose_covariance.hpp>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>

namespace lcmslam {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Entries = std::vector<Eigen::Triplet<double>>;

// Block (row, column) of H, in poses; the first one is no unknown.
void add(const Matrix6d& block, int row, int column, Entries& entries) {
  if (row < 1 || column < 1) return;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) entries.emplace_back(6 * (row - 1) + r, 6 * (column - 1) + c, block(r, c));
}

/// One column for each error that all edges share.
using Shared = Eigen::Matrix<double, 6, 2>;

// Too long and too far: Z_true = Z exp(b), a part of what Z measures, as the second pose's body has it.
Shared shared_error(const GraphEdge& edge, const PoseGraphSettings& settings) {
  const Eigen::Isometry3d& Z = edge.T_from_to.T;
  Shared b = Shared::Zero();
  b.block<3, 1>(0, 0) = settings.motion_scale * (Z.linear().transpose() * Z.translation());
  b.block<3, 1>(3, 1) = settings.turn_scale * se3_log(Z).tail<3>();
  return b;
}

struct GraphEquations {
  Entries H;
  Eigen::MatrixXd shared;  ///< sum J^T R^-1 b
};

GraphEquations equations_of(const PoseGraph& graph, const PoseGraphSettings& settings) {
  GraphEquations equations;
  equations.shared.setZero(static_cast<Eigen::Index>(6 * (graph.poses.size() - 1)),
                           Shared::ColsAtCompileTime);
  const auto add_shared = [&](int node, const Shared& rows) {
    if (node > 0) equations.shared.middleRows<6>(6 * (node - 1)) += rows;
  };
  for (const GraphEdge& e : graph.edges) {
    // e = log(Z^-1 T_i^-1 T_j exp(x_j)), and x_i is felt at j as -Ad(T_j^-1 T_i) x_i.
    const Eigen::Isometry3d& T_from = graph.poses[static_cast<std::size_t>(e.from)];
    const Eigen::Isometry3d& T_to = graph.poses[static_cast<std::size_t>(e.to)];
    const Matrix6d J = -adjoint(T_to.inverse() * T_from);
    const Matrix6d W = edge_error(e.T_from_to.covariance, settings).inverse();
    const Matrix6d WJ = W * J;
    add(J.transpose() * WJ, e.from, e.from, equations.H);
    add(WJ, e.to, e.from, equations.H);
    add(WJ.transpose(), e.from, e.to, equations.H);
    add(W, e.to, e.to, equations.H);
    const Shared b = shared_error(e, settings);
    add_shared(e.from, WJ.transpose() * b);
    add_shared(e.to, W * b);
  }
  if (!graph.ground) return equations;
  const Matrix6d A = adjoint(graph.ground->T_camera_robot.inverse());
  for (std::size_t i = 1; i < graph.poses.size(); ++i) {
    const Eigen::Vector3d sigmas = settings.ground_error * graph.ground->sigmas(i);
    Vector6d ground = Vector6d::Zero();
    ground.segment<3>(2) = sigmas.cwiseAbs2().cwiseInverse();
    const Matrix6d block = A.transpose() * ground.asDiagonal() * A;
    add(block, static_cast<int>(i), static_cast<int>(i), equations.H);
  }
  return equations;
}

/// The entries of (L D L^T)^-1 where L has some, column by column from the last:
///   Z_ij = -sum_k Z_ik L_kj,   Z_jj = 1 / D_j - sum_k Z_jk L_kj   (k > j in L's column j).
class SparseInverse {
 public:
  SparseInverse(const Sparse& L, const Eigen::VectorXd& D) : Z_(L) {
    const int n = static_cast<int>(L.cols());
    diagonal_ = D.cwiseInverse();
    for (int j = n - 1; j >= 0; --j) {
      const int begin = L.outerIndexPtr()[j], end = L.outerIndexPtr()[j + 1];
      const int first =
          begin < end && L.innerIndexPtr()[begin] == j ? begin + 1 : begin;  // behind a stored 1
      for (int a = first; a < end; ++a) {
        double sum = 0;
        for (int b = first; b < end; ++b)
          sum -= at(L.innerIndexPtr()[a], L.innerIndexPtr()[b]) * L.valuePtr()[b];
        Z_.valuePtr()[a] = sum;
      }
      for (int b = first; b < end; ++b) diagonal_(j) -= Z_.valuePtr()[b] * L.valuePtr()[b];
    }
  }

  /// Zero where L has no entry.
  double at(int i, int j) const {
    if (i == j) return diagonal_(i);
    const int row = std::max(i, j), column = std::min(i, j);
    const int* const begin = Z_.innerIndexPtr() + Z_.outerIndexPtr()[column];
    const int* const end = Z_.innerIndexPtr() + Z_.outerIndexPtr()[column + 1];
    const int* const found = std::lower_bound(begin, end, row);
    return found != end && *found == row ? Z_.valuePtr()[found - Z_.innerIndexPtr()] : 0;
  }

 private:
  Sparse Z_;
  Eigen::VectorXd diagonal_;
};

}  // namespace

Matrix6d edge_error(const Matrix6d& covariance, const PoseGraphSettings& settings) {
  return settings.edge_error * settings.edge_error * covariance;
}

std::vector<Matrix6d> pose_covariances(const PoseGraph& graph, const PoseGraphSettings& settings) {
  std::vector<Matrix6d> covariances(graph.poses.size(), Matrix6d::Zero());
  if (graph.poses.size() < 2) return covariances;
  const auto unknowns = static_cast<Eigen::Index>(6 * (graph.poses.size() - 1));
  const GraphEquations equations = equations_of(graph, settings);
  Sparse H(unknowns, unknowns);
  H.setFromTriplets(equations.H.begin(), equations.H.end());
  const Eigen::SimplicialLDLT<Sparse> factor(H);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0)) return {};
  Sparse L = factor.matrixL();
  L.makeCompressed();
  const SparseInverse inverse(L, factor.vectorD());
  const auto& place = factor.permutationP().indices();  // of an unknown in the factor
  const Eigen::MatrixXd G = factor.solve(equations.shared);
  for (std::size_t i = 1; i < graph.poses.size(); ++i) {
    const auto first = static_cast<Eigen::Index>(6 * (i - 1));
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c) covariances[i](r, c) = inverse.at(place(first + r), place(first + c));
    const Shared shared = G.middleRows<6>(first);
    covariances[i] += shared * shared.transpose();
  }
  return covariances;
}

}  // namespace lcmslam

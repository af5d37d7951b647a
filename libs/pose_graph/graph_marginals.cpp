#include <lcmslam/pose_graph/graph_marginals.hpp>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <map>
#include <utility>

#include <lcmslam/geometry/mount_error.hpp>

namespace lcmslam {
namespace {

using Entries = std::vector<Eigen::Triplet<double>>;

// Block (row, column) of H, in poses; the first one is no unknown.
void add(const Matrix6d& block, int row, int column, Entries& entries) {
  if (row < 1 || column < 1) return;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) entries.emplace_back(6 * (row - 1) + r, 6 * (column - 1) + c, block(r, c));
}

constexpr int of_mount = 6, of_stretch = 2;  // columns of what is shared, the mount's before the edges'
constexpr int turned = of_mount;             // one of all edges
constexpr int most_stretches = 32;

/// By edge: on which stretch of the way its later node stands.
struct Stretches {
  std::vector<int> of_edge;
  int count = 1;
};

Stretches stretches_of(const PoseGraph& graph, double length) {
  std::vector<double> way(graph.poses.size(), 0);
  for (std::size_t i = 1; i < way.size(); ++i)
    way[i] = way[i - 1] + distance_between(graph.poses[i - 1], graph.poses[i]);
  const double each = std::max(length, way.back() / most_stretches);
  Stretches stretches;
  for (const GraphEdge& e : graph.edges) {
    const double at = way[static_cast<std::size_t>(std::max(e.from, e.to))];
    stretches.of_edge.push_back(std::min(static_cast<int>(at / each), most_stretches - 1));
    stretches.count = std::max(stretches.count, stretches.of_edge.back() + 1);
  }
  return stretches;
}

// Too far, too long and too bent: Z_true = Z exp(b), a part of what Z measures, as the second pose's body has
// it (`up`: the vertical in that body). How edges contradict each other tells nothing of it.
struct SharedError {
  Vector6d turn = Vector6d::Zero();
  Eigen::Matrix<double, 6, of_stretch> stretch = Eigen::Matrix<double, 6, of_stretch>::Zero();
};

SharedError shared_error(const GraphEdge& edge, const Eigen::Vector3d& up,
                         const PoseGraphSettings& settings) {
  const Eigen::Isometry3d& Z = edge.T_from_to.T;
  SharedError b;
  b.turn.tail<3>() = settings.turn_scale * se3_log(Z).tail<3>();
  b.stretch.block<3, 1>(0, 0) = settings.motion_scale * (Z.linear().transpose() * Z.translation());
  b.stretch.block<3, 1>(3, 1) = settings.curvature * Z.translation().norm() * up;
  return b;
}

struct GraphEquations {
  Entries H;
  Eigen::MatrixXd shared;  ///< of G
};

/// Of each edge: the part of its information that counts.
std::vector<double> shares(const std::vector<GraphEdge>& edges, EdgeErrors errors) {
  const auto group = [](const GraphEdge& e) {
    return std::make_pair(std::max(e.from, e.to), e.kind == EdgeKind::loop);
  };
  std::map<std::pair<int, bool>, int> sizes;
  for (const GraphEdge& e : edges) ++sizes[group(e)];
  std::vector<double> shares;
  shares.reserve(edges.size());
  for (const GraphEdge& e : edges) shares.push_back(errors == EdgeErrors::alike ? 1.0 / sizes[group(e)] : 1);
  return shares;
}

GraphEquations equations_of(const PoseGraph& graph, const PoseGraphSettings& settings,
                            const ErrorFactors& factors, EdgeErrors errors) {
  GraphEquations equations;
  const Stretches stretches = stretches_of(graph, settings.stretch);
  equations.shared.setZero(static_cast<Eigen::Index>(6 * (graph.poses.size() - 1)),
                           of_mount + 1 + of_stretch * stretches.count);
  const auto add_shared = [&](int node, int column, const auto& rows) {
    if (node > 0) equations.shared.block(6 * (node - 1), column, 6, rows.cols()) += rows;
  };
  const std::vector<double> share = shares(graph.edges, errors);
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const GraphEdge& e = graph.edges[i];
    // e = log(Z^-1 T_i^-1 T_j exp(x_j)), and x_i is felt at j as -Ad(T_j^-1 T_i) x_i.
    const Eigen::Isometry3d& T_from = graph.poses[static_cast<std::size_t>(e.from)];
    const Eigen::Isometry3d& T_to = graph.poses[static_cast<std::size_t>(e.to)];
    const Matrix6d J = -adjoint(T_to.inverse() * T_from);
    const Matrix6d W = share[i] * edge_error(e, settings, factors).inverse();
    const Matrix6d WJ = W * J;
    add(J.transpose() * WJ, e.from, e.from, equations.H);
    add(WJ, e.to, e.from, equations.H);
    add(WJ.transpose(), e.from, e.to, equations.H);
    add(W, e.to, e.to, equations.H);
    const SharedError b = shared_error(e, T_to.linear().transpose().col(2), settings);
    const int bent = turned + 1 + of_stretch * stretches.of_edge[i];
    for (const auto& [node, felt] : {std::make_pair(e.from, Matrix6d(WJ.transpose())), {e.to, W}}) {
      add_shared(node, turned, (felt * b.turn).eval());
      add_shared(node, bent, (felt * b.stretch).eval());
    }
  }
  if (!graph.ground) return equations;
  for (std::size_t i = 1; i < graph.poses.size(); ++i) {
    const auto node = static_cast<int>(i);
    const Matrix6d W = ground_information(*graph.ground, i, settings, factors);
    add(W, node, node, equations.H);
    equations.shared.block<6, of_mount>(6 * (node - 1), 0) +=
        W * mount_lever(graph.poses.front().inverse() * graph.poses[i]) *
        graph.ground->mount_sigmas.asDiagonal();
  }
  return equations;
}

}  // namespace

// Column by column from the last: Z_ij = -sum_k Z_ik L_kj,  Z_jj = 1 / D_j - sum_k Z_jk L_kj  (k > j in L's
// column j).
std::optional<GraphMarginals> GraphMarginals::of(const PoseGraph& graph, const PoseGraphSettings& settings,
                                                 const ErrorFactors& factors, EdgeErrors errors) {
  if (graph.poses.size() < 2) return std::nullopt;
  const auto unknowns = static_cast<Eigen::Index>(6 * (graph.poses.size() - 1));
  const GraphEquations equations = equations_of(graph, settings, factors, errors);
  Eigen::SparseMatrix<double> H(unknowns, unknowns);
  H.setFromTriplets(equations.H.begin(), equations.H.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(H);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0)) return std::nullopt;
  GraphMarginals m;
  m.place_ = factor.permutationP().indices();
  m.shared_ = factor.solve(equations.shared);
  Eigen::SparseMatrix<double> L = factor.matrixL();
  L.makeCompressed();
  m.inverse_ = L;
  m.diagonal_ = factor.vectorD().cwiseInverse();
  const int* const rows = L.innerIndexPtr();
  for (int j = static_cast<int>(L.cols()) - 1; j >= 0; --j) {
    const int begin = L.outerIndexPtr()[j], end = L.outerIndexPtr()[j + 1];
    const int first = begin < end && rows[begin] == j ? begin + 1 : begin;  // behind a stored 1
    // Each of column k's entries once, for both places where it counts; L's column k has those of column j
    // below k.
    double* const sums = m.inverse_.valuePtr();
    std::fill(sums + first, sums + end, 0);
    for (int b = first; b < end; ++b) {
      const int k = rows[b];
      sums[b] -= m.diagonal_(k) * L.valuePtr()[b];
      int p = L.outerIndexPtr()[k];
      for (int a = b + 1; a < end; ++a) {
        while (rows[p] < rows[a]) ++p;
        sums[a] -= sums[p] * L.valuePtr()[b];
        sums[b] -= sums[p] * L.valuePtr()[a];
      }
    }
    for (int b = first; b < end; ++b) m.diagonal_(j) -= m.inverse_.valuePtr()[b] * L.valuePtr()[b];
  }
  return m;
}

// Zero where L has no entry.
double GraphMarginals::at(int i, int j) const {
  if (i == j) return diagonal_(i);
  const int row = std::max(i, j), column = std::min(i, j);
  const int* const begin = inverse_.innerIndexPtr() + inverse_.outerIndexPtr()[column];
  const int* const end = inverse_.innerIndexPtr() + inverse_.outerIndexPtr()[column + 1];
  const int* const found = std::lower_bound(begin, end, row);
  return found != end && *found == row ? inverse_.valuePtr()[found - inverse_.innerIndexPtr()] : 0;
}

Matrix6d GraphMarginals::block(int i, int j) const {
  Matrix6d block = Matrix6d::Zero();
  if (i < 1 || j < 1) return block;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) block(r, c) = at(place_(6 * (i - 1) + r), place_(6 * (j - 1) + c));
  return block;
}

GraphMarginals::Shared GraphMarginals::shared(int i) const {
  const Eigen::Index columns = shared_.cols() - of_mount;
  if (i < 1) return {Eigen::MatrixXd::Zero(6, columns), Matrix6d::Zero()};
  const auto rows = shared_.middleRows<6>(6 * (i - 1));
  return {rows.rightCols(columns), rows.leftCols<of_mount>()};
}

}  // namespace lcmslam

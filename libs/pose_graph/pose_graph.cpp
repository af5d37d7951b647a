#include <lcmslam/pose_graph/pose_graph.hpp>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <limits>
#include <queue>
#include <set>

namespace lcmslam {
namespace {

using Pose = std::array<double, 7>;  // translation, quaternion x y z w

Pose to_pose(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  return {T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w()};
}

Eigen::Isometry3d from_pose(const Pose& p) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(p[6], p[3], p[4], p[5]).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return T;
}

// L^-1 of S = L L^T: residuals times this have unit covariance.
Matrix6d root_information(const Matrix6d& covariance) {
  return covariance.llt().matrixL().solve(Matrix6d::Identity());
}

struct RelativePoseError {
  Eigen::Isometry3d T_from_to;
  Matrix6d root;

  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Eigen::Map<const Vector> t_a(a), t_b(b);
    const Eigen::Map<const Quaternion> q_a(a + 3), q_b(b + 3);
    const Quaternion q_z = Eigen::Quaterniond(T_from_to.linear()).cast<T>();
    const Vector moved = q_a.conjugate() * Vector(t_b - t_a);
    const Vector translation = q_z.conjugate() * Vector(moved - T_from_to.translation().cast<T>());
    const Quaternion turn = q_z.conjugate() * (q_a.conjugate() * q_b);
    const T sign = turn.w() < T(0) ? T(-1) : T(1);
    Eigen::Matrix<T, 6, 1> e;
    e << translation, T(2) * sign * turn.vec();  // twice the sine of half the angle: the angle where small
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residual);
    r = root.cast<T>() * e;
    return true;
  }
};

struct GroundError {
  Eigen::Isometry3d T_camera_robot;
  double height, tilt;  // sigmas

  template <class T>
  bool operator()(const T* pose, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector> t(pose);
    const Eigen::Map<const Eigen::Quaternion<T>> q(pose + 3);
    const Vector up = q * Vector(T_camera_robot.linear().col(2).cast<T>());
    const Vector place = q * Vector(T_camera_robot.translation().cast<T>()) + t;
    residual[0] = place.z() / height;
    residual[1] = up.x() / tilt;
    residual[2] = up.y() / tilt;
    return true;
  }
};

// A wide kernel first lets true loops pull from far, the narrow one then lets go of false ones
// (graduated non-convexity: Blake and Zisserman 1987).
constexpr double kernel_stages[] = {100, 10, 1};

void solve(PoseGraph& graph, const PoseGraphSettings& settings) {
  std::vector<Pose> poses;
  for (const Eigen::Isometry3d& T : graph.poses) poses.push_back(to_pose(T));
  for (const double stage : kernel_stages) {
    ceres::Problem problem;
    for (const GraphEdge& e : graph.edges) {
      auto* error = new RelativePoseError{e.T_from_to.T, root_information(e.T_from_to.covariance)};
      auto* kernel =
          e.kind == EdgeKind::odometry ? nullptr : new ceres::CauchyLoss(stage * settings.kernel_width);
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RelativePoseError, 6, 7, 7>(error), kernel,
                               poses[static_cast<std::size_t>(e.from)].data(),
                               poses[static_cast<std::size_t>(e.to)].data());
    }
    using Manifold = ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::EigenQuaternionManifold>;
    for (Pose& pose : poses) {
      if (!problem.HasParameterBlock(pose.data())) continue;
      problem.SetManifold(pose.data(), new Manifold);
      if (&pose == &poses.front()) {
        problem.SetParameterBlockConstant(pose.data());
      } else if (graph.ground) {
        const Eigen::Vector3d sigmas = graph.ground->sigmas(static_cast<std::size_t>(&pose - poses.data()));
        auto* error = new GroundError{graph.ground->T_camera_robot, sigmas.x(), sigmas.y()};
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<GroundError, 3, 7>(error), nullptr,
                                 pose.data());
      }
    }
    ceres::Solver::Options options;
    options.num_threads = 1;  // the same result everywhere
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    options.max_num_iterations = settings.max_iterations;
    options.function_tolerance = 1e-6;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) return;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) graph.poses[i] = from_pose(poses[i]);
}

double size_of(const Matrix6d& covariance) {
  constexpr double arm = 2;  // m: how far away a rotation's error is felt
  return covariance.topLeftCorner<3, 3>().trace() + arm * arm * covariance.bottomRightCorner<3, 3>().trace();
}

UncertainTransform expectation(const GraphEdge& e) {
  return {e.T_from_to.T, e.expected_share * e.expected_share * e.T_from_to.covariance};
}

}  // namespace

UncertainTransform operator*(const UncertainTransform& a, const UncertainTransform& b) {
  const Matrix6d A = adjoint(b.T.inverse());
  return {a.T * b.T, A * a.covariance * A.transpose() + b.covariance};
}

UncertainTransform inverse(const UncertainTransform& a) {
  const Matrix6d A = adjoint(a.T);
  return {a.T.inverse(), A * a.covariance * A.transpose()};
}

double distance_from_identity(const UncertainTransform& a) {
  const Vector6d e = se3_log(a.T);
  return std::sqrt(std::max(0.0, e.dot(a.covariance.ldlt().solve(e))));
}

double error_over_sigma(const GraphEdge& edge, const PoseGraph& graph) {
  const Eigen::Isometry3d& T_from = graph.poses[static_cast<std::size_t>(edge.from)];
  const Eigen::Isometry3d& T_to = graph.poses[static_cast<std::size_t>(edge.to)];
  return distance_from_identity(
      {edge.T_from_to.T.inverse() * T_from.inverse() * T_to, edge.T_from_to.covariance});
}

// Dijkstra (1959) over the edges' sizes; the covariance is compounded along the way.
std::optional<UncertainTransform> expected(const PoseGraph& graph, int from, int to) {
  const std::size_t n = graph.poses.size();
  std::vector<std::vector<const GraphEdge*>> edges(n);
  for (const GraphEdge& e : graph.edges) {
    edges[static_cast<std::size_t>(e.from)].push_back(&e);
    edges[static_cast<std::size_t>(e.to)].push_back(&e);
  }
  std::vector<double> cost(n, std::numeric_limits<double>::infinity());
  std::vector<UncertainTransform> way(n);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
  cost[static_cast<std::size_t>(from)] = 0;
  open.push({0, from});
  while (!open.empty()) {
    const auto [c, here] = open.top();
    open.pop();
    const auto h = static_cast<std::size_t>(here);
    if (c > cost[h]) continue;
    if (here == to) break;
    for (const GraphEdge* e : edges[h]) {
      const bool forward = e->from == here;
      const auto next = static_cast<std::size_t>(forward ? e->to : e->from);
      const double there = c + e->expected_share * e->expected_share * size_of(e->T_from_to.covariance);
      if (there >= cost[next]) continue;
      cost[next] = there;
      UncertainTransform step = forward ? expectation(*e) : inverse(expectation(*e));
      step.T = graph.poses[h].inverse() * graph.poses[next];  // the graph's poses, the edge's covariance
      way[next] = way[h] * step;
      open.push({there, static_cast<int>(next)});
    }
  }
  if (!std::isfinite(cost[static_cast<std::size_t>(to)])) return std::nullopt;
  return way[static_cast<std::size_t>(to)];
}

bool consistent(const GraphEdge& a, const GraphEdge& b, const PoseGraph& graph,
                const PoseGraphSettings& settings) {
  const auto between_ends = expected(graph, a.to, b.to);
  const auto between_starts = expected(graph, b.from, a.from);
  if (!between_ends || !between_starts) return false;
  const UncertainTransform circle = a.T_from_to * *between_ends * inverse(b.T_from_to) * *between_starts;
  return distance_from_identity(circle) < settings.path_gate;
}

int admit(std::vector<GraphEdge>& waiting, PoseGraph& graph, const PoseGraphSettings& settings) {
  std::vector<bool> believed(waiting.size(), false);
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    const auto known = expected(graph, waiting[i].from, waiting[i].to);
    believed[i] =
        known && distance_from_identity(inverse(waiting[i].T_from_to) * *known) < settings.path_gate;
  }
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    if (believed[i]) continue;
    std::set<int> places = {waiting[i].to};
    for (std::size_t k = 0; k < waiting.size(); ++k)
      if (k != i && waiting[k].to != waiting[i].to && consistent(waiting[i], waiting[k], graph, settings))
        places.insert(waiting[k].to);
    believed[i] = static_cast<int>(places.size()) >= settings.loop_support;
  }
  std::vector<GraphEdge> rest;
  for (std::size_t i = 0; i < waiting.size(); ++i) (believed[i] ? graph.edges : rest).push_back(waiting[i]);
  const auto added = static_cast<int>(waiting.size() - rest.size());
  waiting = std::move(rest);
  return added;
}

bool has_circle(const std::vector<GraphEdge>& edges, std::size_t first) {
  return std::any_of(edges.begin() + static_cast<std::ptrdiff_t>(first), edges.end(),
                     [](const GraphEdge& e) { return e.to - e.from > 1; });
}

bool close_circles(std::vector<GraphEdge>& waiting, PoseGraph& graph, const PoseGraphSettings& settings) {
  const std::size_t before = graph.edges.size();
  admit(waiting, graph, settings);
  if (!has_circle(graph.edges, before)) return false;
  optimise(graph, settings);
  return true;
}

int optimise(PoseGraph& graph, const PoseGraphSettings& settings) {
  if (graph.poses.size() < 2 || graph.edges.empty()) return 0;
  int refused = 0;
  for (bool again = true; again;) {
    solve(graph, settings);
    for (GraphEdge& e : graph.edges) e.error = error_over_sigma(e, graph);
    const std::size_t before = graph.edges.size();
    graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(),
                                     [&](const GraphEdge& e) {
                                       return e.kind != EdgeKind::odometry && e.error > settings.max_error;
                                     }),
                      graph.edges.end());
    again = graph.edges.size() < before;
    refused += static_cast<int>(before - graph.edges.size());
  }
  return refused;
}

}  // namespace lcmslam

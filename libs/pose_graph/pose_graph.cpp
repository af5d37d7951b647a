#include <lcmslam/pose_graph/pose_graph.hpp>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

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

}  // namespace

double error_over_sigma(const GraphEdge& edge, const PoseGraph& graph) {
  const Eigen::Isometry3d& T_from = graph.poses[static_cast<std::size_t>(edge.from)];
  const Eigen::Isometry3d& T_to = graph.poses[static_cast<std::size_t>(edge.to)];
  return distance_from_identity(
      {edge.T_from_to.T.inverse() * T_from.inverse() * T_to, edge.T_from_to.covariance});
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

#include <lcmslam/calibration/camera_pair.hpp>

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/calibration/lens.hpp>
#include <lcmslam/calibration/moved_pose.hpp>

namespace lcmslam {
namespace {

using Intrinsics = std::array<double, 4>;  // fx, fy, cx, cy

/// A corner in the colour image.
struct ColourError {
  const CameraModel& camera;
  Eigen::Isometry3d T_colour_board;  // start
  Eigen::Vector3d point;             // board
  Eigen::Vector2d pixel;

  template <class T>
  bool operator()(const T* board, T* residual) const {
    const T k[4] = {T(camera.fx), T(camera.fy), T(camera.cx), T(camera.cy)};
    const Eigen::Matrix<T, 3, 1> p = MovedPose<T>(T_colour_board, board) * point.cast<T>().eval();
    Eigen::Map<Eigen::Matrix<T, 2, 1>>{residual} =
        project_through_lens(k, camera.distortion, p) - pixel.cast<T>().eval();
    return true;
  }
};

/// A corner in the depth camera's image: board -> colour camera -> depth camera.
struct DepthCameraError {
  const CameraModel& camera;
  Eigen::Isometry3d T_colour_board, T_colour_depth;  // starts
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;

  template <class T>
  bool operator()(const T* board, const T* pair, const T* intrinsics, T* residual) const {
    const Eigen::Matrix<T, 3, 1> colour = MovedPose<T>(T_colour_board, board) * point.cast<T>().eval();
    const Eigen::Matrix<T, 3, 1> p = MovedPose<T>(T_colour_depth, pair).inverse_of(colour);
    Eigen::Map<Eigen::Matrix<T, 2, 1>>{residual} =
        project_through_lens(intrinsics, camera.distortion, p) - pixel.cast<T>().eval();
    return true;
  }
};

/// The mean of what each view says alone; rotations are near each other.
Eigen::Isometry3d mean_of(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> coordinates[3];
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Isometry3d& T : poses) {
    for (int i = 0; i < 3; ++i) coordinates[i].push_back(T.translation()[i]);
    sum += T.linear();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d mean = Eigen::Isometry3d::Identity();
  mean.linear() = svd.matrixU() * svd.matrixV().transpose();
  for (int i = 0; i < 3; ++i) {
    std::sort(coordinates[i].begin(), coordinates[i].end());
    mean.translation()[i] = coordinates[i][coordinates[i].size() / 2];
  }
  return mean;
}

/// Everything that is refined, and where it begins.
struct PairProblem {
  PairProblem(const std::vector<PairView>& views, const Board& board, const CameraModel& colour_camera,
              const CameraModel& depth_camera)
      : colour(colour_camera), depth(depth_camera) {
    std::vector<Eigen::Isometry3d> pairs;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const PairView& view = views[i];
      const auto T_colour = board_pose(view.colour, board, colour),
                 T_depth = board_pose(view.depth, board, depth);
      if (!T_colour || !T_depth) continue;
      used.push_back(&view);
      places.push_back(i);
      T_colour_board.push_back(*T_colour);
      pairs.push_back(*T_colour * T_depth->inverse());
    }
    if (used.size() < 3)
      throw std::invalid_argument(
          "a pair of cameras needs at least three views of the board in both, there are " +
          std::to_string(used.size()));
    T_colour_depth = mean_of(pairs);
    boards.resize(used.size(), PoseStep{});
    for (std::size_t i = 0; i < used.size(); ++i) add(i, board);
  }

  void add(std::size_t i, const Board& board) {
    constexpr double kernel = 1.0;  // pixels: farther off, a corner was another thing
    const PairView& view = *used[i];
    for (std::size_t k = 0; k < view.colour.ids.size(); ++k)
      colour_blocks.push_back(problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<ColourError, 2, 6>(new ColourError{
              colour, T_colour_board[i], board.corner(view.colour.ids[k]), view.colour.pixels[k]}),
          new ceres::HuberLoss(kernel), boards[i].data()));
    for (std::size_t k = 0; k < view.depth.ids.size(); ++k)
      depth_blocks.push_back(problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<DepthCameraError, 2, 6, 6, 4>(
              new DepthCameraError{depth, T_colour_board[i], T_colour_depth, board.corner(view.depth.ids[k]),
                                   view.depth.pixels[k]}),
          new ceres::HuberLoss(kernel), boards[i].data(), pair.data(), intrinsics.data()));
  }

  /// Pixels on one axis.
  double rms(const std::vector<ceres::ResidualBlockId>& blocks) {
    ceres::Problem::EvaluateOptions options;
    options.residual_blocks = blocks;
    options.apply_loss_function = false;
    double cost = 0;
    problem.Evaluate(options, &cost, nullptr, nullptr, nullptr);
    return std::sqrt(2 * cost / (2.0 * static_cast<double>(blocks.size())));
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) throw std::runtime_error("the pair of cameras: " + summary.message);
  }

  const CameraModel& colour;
  const CameraModel& depth;
  std::vector<const PairView*> used;
  std::vector<std::size_t> places;  // of them in the list of all
  std::vector<Eigen::Isometry3d> T_colour_board;
  Eigen::Isometry3d T_colour_depth;
  std::vector<PoseStep> boards;
  PoseStep pair{};
  Intrinsics intrinsics{depth.fx, depth.fy, depth.cx, depth.cy};
  ceres::Problem problem;
  std::vector<ceres::ResidualBlockId> colour_blocks, depth_blocks;
};

}  // namespace

PairCalibration calibrate_pair(const std::vector<PairView>& views, const Board& board,
                               const CameraModel& colour, const CameraModel& depth,
                               const PairSettings& settings) {
  PairProblem p(views, board, colour, depth);
  if (!settings.refine_depth_camera) p.problem.SetParameterBlockConstant(p.intrinsics.data());
  p.solve();

  PairCalibration result;
  result.T_colour_depth = moved(p.T_colour_depth, p.pair);
  result.views = static_cast<int>(p.used.size());
  result.T_depth_board.resize(views.size());
  for (std::size_t i = 0; i < p.used.size(); ++i)
    result.T_depth_board[p.places[i]] =
        result.T_colour_depth.inverse() * moved(p.T_colour_board[i], p.boards[i]);
  result.colour_rms = p.rms(p.colour_blocks);
  result.depth_rms = p.rms(p.depth_blocks);
  result.depth = depth;
  result.depth.fx = p.intrinsics[0], result.depth.fy = p.intrinsics[1];
  result.depth.cx = p.intrinsics[2], result.depth.cy = p.intrinsics[3];

  // Residuals are in pixels; their variance is what the solution leaves of them, the larger of both cameras'.
  ceres::Covariance::Options options;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  ceres::Covariance covariance(options);
  std::vector<std::pair<const double*, const double*>> blocks = {{p.pair.data(), p.pair.data()}};
  if (settings.refine_depth_camera) blocks.emplace_back(p.intrinsics.data(), p.intrinsics.data());
  if (!covariance.Compute(blocks, &p.problem))
    throw std::runtime_error(
        "the views do not tell how the cameras sit on each other: hold the board tilted, at "
        "several distances");
  const double variance = std::pow(std::max(result.colour_rms, result.depth_rms), 2);
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> pair;
  covariance.GetCovarianceBlock(p.pair.data(), p.pair.data(), pair.data());
  result.covariance = variance * pair;
  if (settings.refine_depth_camera) {
    Eigen::Matrix<double, 4, 4, Eigen::RowMajor> intrinsics;
    covariance.GetCovarianceBlock(p.intrinsics.data(), p.intrinsics.data(), intrinsics.data());
    result.depth_covariance = variance * intrinsics;
  }
  return result;
}

}  // namespace lcmslam

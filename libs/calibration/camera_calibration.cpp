#include <lcmslam/calibration/camera_calibration.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_views = 3;

std::vector<cv::Point3f> points_of(const BoardView& view, const Board& board) {
  std::vector<cv::Point3f> points;
  for (const int id : view.ids) {
    const Eigen::Vector3f p = board.corner(id).cast<float>();
    points.emplace_back(p.x(), p.y(), p.z());
  }
  return points;
}

std::vector<cv::Point2f> pixels_of(const BoardView& view) {
  std::vector<cv::Point2f> pixels;
  for (const auto& p : view.pixels) pixels.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  return pixels;
}

int flags_of(int coefficients) {
  switch (coefficients) {
    case 0:
      return cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST;
    case 4:
      return cv::CALIB_FIX_K3;
    case 8:
      return cv::CALIB_RATIONAL_MODEL;
    default:
      return 0;
  }
}

int corner_count(const std::vector<BoardView>& views) {
  int count = 0;
  for (const BoardView& view : views) count += static_cast<int>(view.ids.size());
  return count;
}

/// Normal equations of all views, the boards' poses eliminated (Schur complement).
class IntrinsicInformation {
 public:
  explicit IntrinsicInformation(int parameters)
      : information_(Eigen::MatrixXd::Zero(parameters, parameters)) {}

  void add(const Eigen::MatrixXd& by_intrinsics, const Eigen::MatrixXd& by_pose) {
    const Eigen::MatrixXd cross = by_pose.transpose() * by_intrinsics;
    const Eigen::MatrixXd pose = by_pose.transpose() * by_pose;
    information_ += by_intrinsics.transpose() * by_intrinsics - cross.transpose() * pose.ldlt().solve(cross);
  }
  Eigen::MatrixXd inverse() const {
    // fx is some hundred pixels, k3 a hundredth: scaled to one diagonal first.
    const Eigen::VectorXd scale = information_.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * information_ * scale.asDiagonal();
    const Eigen::LDLT<Eigen::MatrixXd> solver(scaled);
    if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-15))
      throw std::runtime_error(
          "the views do not determine the camera: show the board tilted, from several sides");
    const Eigen::MatrixXd inverse = solver.solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
    return scale.asDiagonal() * inverse * scale.asDiagonal();
  }

 private:
  Eigen::MatrixXd information_;
};

/// Residuals of a view, and its part of the information.
void judge(CalibratedView& calibrated, const cv::Vec3d& r, const cv::Vec3d& t, const Board& board,
           const CameraModel& camera, IntrinsicInformation& information) {
  std::vector<double> distortion = camera.distortion;
  if (distortion.empty()) distortion.assign(4, 0.0);
  std::vector<cv::Point2f> projected;
  cv::Mat jacobian;
  cv::projectPoints(points_of(calibrated.view, board), r, t, camera.matrix(), distortion, projected,
                    jacobian);
  double squares = 0;
  for (std::size_t i = 0; i < projected.size(); ++i) {
    const Eigen::Vector2d p(static_cast<double>(projected[i].x), static_cast<double>(projected[i].y));
    calibrated.residuals.push_back(calibrated.view.pixels[i] - p);
    squares += calibrated.residuals.back().squaredNorm();
  }
  calibrated.rms = std::sqrt(squares / (2.0 * static_cast<double>(projected.size())));
  calibrated.T_camera_board.linear() = so3_exp({r[0], r[1], r[2]});
  calibrated.T_camera_board.translation() << t[0], t[1], t[2];
  // OpenCV's columns: rotation, translation, f, c, distortion.
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J(
      jacobian.ptr<double>(), jacobian.rows, jacobian.cols);
  information.add(J.middleCols(6, 4 + static_cast<int>(camera.distortion.size())), J.leftCols(6));
}

CameraCalibration fit(const std::vector<BoardView>& views, const Board& board, cv::Size size,
                      int coefficients) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BoardView& view : views) {
    points.push_back(points_of(view, board));
    pixels.push_back(pixels_of(view));
  }
  cv::Mat matrix;
  std::vector<double> distortion;
  std::vector<cv::Mat> r, t;
  cv::calibrateCamera(points, pixels, size, matrix, distortion, r, t, flags_of(coefficients),
                      {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-10});
  CameraCalibration result;
  CameraModel& camera = result.camera;
  camera.width = size.width, camera.height = size.height;
  camera.fx = matrix.at<double>(0, 0), camera.fy = matrix.at<double>(1, 1);
  camera.cx = matrix.at<double>(0, 2), camera.cy = matrix.at<double>(1, 2);
  distortion.resize(static_cast<std::size_t>(coefficients));
  camera.distortion = distortion;

  IntrinsicInformation information(4 + coefficients);
  double squares = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    CalibratedView calibrated;
    calibrated.view = views[i];
    judge(calibrated, r[i].reshape(1, 3), t[i].reshape(1, 3), board, camera, information);
    for (const auto& residual : calibrated.residuals) squares += residual.squaredNorm();
    result.views.push_back(std::move(calibrated));
  }
  const int measurements = 2 * corner_count(views);
  const int unknowns = 4 + coefficients + 6 * static_cast<int>(views.size());
  result.rms = std::sqrt(squares / measurements);
  result.covariance = squares / std::max(1, measurements - unknowns) * information.inverse();
  return result;
}

/// Bayesian information criterion, up to a constant: what a further coefficient must gain to be worth it.
double bic(const CameraCalibration& c, const std::vector<BoardView>& views) {
  const double n = 2.0 * corner_count(views);
  return n * std::log(c.rms * c.rms) + static_cast<double>(c.camera.distortion.size()) * std::log(n);
}

CameraCalibration fit_best(const std::vector<BoardView>& views, const Board& board, cv::Size size,
                           int coefficients) {
  if (coefficients >= 0) return fit(views, board, size, coefficients);
  CameraCalibration best = fit(views, board, size, 0);
  for (const int more : {4, 5}) try {
      CameraCalibration other = fit(views, board, size, more);
      if (bic(other, views) < bic(best, views)) best = std::move(other);
    } catch (const std::runtime_error&) {
      break;  // more than the views bear
    }
  return best;
}

/// The views without corners that lie beyond `limit` pixels; views that lose most of theirs go as a whole.
std::vector<BoardView> without_outliers(const CameraCalibration& calibration, double limit) {
  constexpr std::size_t least_kept = 8;
  std::vector<BoardView> views;
  for (const CalibratedView& c : calibration.views) {
    BoardView kept{c.view.name, {}, {}};
    for (std::size_t i = 0; i < c.residuals.size(); ++i) {
      if (c.residuals[i].norm() > limit) continue;
      kept.ids.push_back(c.view.ids[i]);
      kept.pixels.push_back(c.view.pixels[i]);
    }
    if (kept.ids.size() >= least_kept) views.push_back(std::move(kept));
  }
  return views;
}

/// Standard deviation on one axis from the median, which outliers do not move: 1.1774 sigma is a Rayleigh
/// distribution's.
double robust_sigma(const CameraCalibration& calibration) {
  std::vector<double> norms;
  for (const CalibratedView& c : calibration.views)
    for (const auto& residual : c.residuals) norms.push_back(residual.norm());
  const auto middle = norms.begin() + static_cast<std::ptrdiff_t>(norms.size() / 2);
  std::nth_element(norms.begin(), middle, norms.end());
  return *middle / 1.1774;
}

}  // namespace

CameraCalibration calibrate_camera(const std::vector<BoardView>& views, const Board& board,
                                   cv::Size image_size, const CameraCalibrationSettings& settings) {
  if (views.size() < fewest_views)
    throw std::invalid_argument("a camera needs at least three views of the board, there are " +
                                std::to_string(views.size()));
  try {
    CameraCalibration all = fit_best(views, board, image_size, settings.coefficients);
    const auto kept = without_outliers(all, settings.outlier * robust_sigma(all));
    const int outliers = corner_count(views) - corner_count(kept);
    if (outliers == 0 || kept.size() < fewest_views) return all;
    CameraCalibration result = fit_best(kept, board, image_size, settings.coefficients);
    result.outliers = outliers;
    return result;
  } catch (const cv::Exception& error) {
    throw std::runtime_error("the views do not determine the camera: " + error.err);
  }
}

}  // namespace lcmslam

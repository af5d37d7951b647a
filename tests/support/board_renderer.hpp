#pragma once
// Pictures of a calibration board as a camera takes them: through the lens, a little out of focus, with
// noise. Everything is known of what they show.

#include <opencv2/imgproc.hpp>

#include <lcmslam/calibration/board.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam::testing {

struct PictureQuality {
  double blur = 0.6;   ///< pixels, standard deviation
  double noise = 2.5;  ///< grey values, standard deviation
  int sub_rays = 3;    ///< of a pixel along each axis
};

class BoardRenderer {
 public:
  BoardRenderer(const Board& board, const CameraModel& camera, const PictureQuality& quality = {})
      : camera_(camera),
        quality_(quality),
        picture_(board.picture(pixels_per_square)),
        scale_(pixels_per_square / board.settings().square) {
    const int n = quality.sub_rays;
    rays_.create(n * camera.height, n * camera.width, CV_32FC2);
    for (int y = 0; y < rays_.rows; ++y)
      for (int x = 0; x < rays_.cols; ++x) {
        const Eigen::Vector3d ray = camera.ray({(x + 0.5) / n - 0.5, (y + 0.5) / n - 0.5});
        rays_.at<cv::Vec2f>(y, x) = {static_cast<float>(ray.x()), static_cast<float>(ray.y())};
      }
  }

  /// CV_8UC1; beside the board a grey wall.
  cv::Mat operator()(const Eigen::Isometry3d& T_camera_board, Random& random) const {
    cv::Mat fine(rays_.size(), CV_32FC1), grey;
    const Eigen::Matrix3d R = T_camera_board.linear().transpose();
    const Eigen::Vector3d origin = -R * T_camera_board.translation();
    for (int y = 0; y < rays_.rows; ++y)
      for (int x = 0; x < rays_.cols; ++x) {
        const cv::Vec2f& ray = rays_.at<cv::Vec2f>(y, x);
        const Eigen::Vector3d d =
            R * Eigen::Vector3d(static_cast<double>(ray[0]), static_cast<double>(ray[1]), 1);
        const double depth = -origin.z() / d.z();
        const Eigen::Vector3d p = origin + depth * d;
        fine.at<float>(y, x) = depth > 0 ? paper(p.x(), p.y()) : wall;
      }
    cv::resize(fine, grey, {camera_.width, camera_.height}, 0, 0, cv::INTER_AREA);
    if (quality_.blur > 0) cv::GaussianBlur(grey, grey, {0, 0}, quality_.blur);
    for (int y = 0; y < grey.rows; ++y)
      for (int x = 0; x < grey.cols; ++x)
        grey.at<float>(y, x) += static_cast<float>(random.normal(0, quality_.noise));
    cv::Mat result;
    grey.convertTo(result, CV_8UC1);
    return result;
  }

 private:
  static constexpr int pixels_per_square = 70;
  static constexpr float wall = 110, white = 210, black = 35;

  float paper(double x, double y) const {
    const double u = scale_ * x + 0.5 * pixels_per_square, v = scale_ * y + 0.5 * pixels_per_square;
    if (!(u >= 0 && v >= 0 && u < picture_.cols && v < picture_.rows)) return wall;
    return picture_.at<std::uint8_t>(static_cast<int>(v), static_cast<int>(u)) != 0 ? white : black;
  }

  CameraModel camera_;
  PictureQuality quality_;
  cv::Mat picture_;
  double scale_;  // pixels of the picture a metre
  cv::Mat rays_;
};

/// Where somebody holds the board before the camera: its middle at `distance` (m) in the direction of
/// `pixel`, turned about the camera's axes by `tilt_x` and `tilt_y` (rad) and in its own plane by `turn`.
inline Eigen::Isometry3d held_board(const Board& board, const CameraModel& camera,
                                    const Eigen::Vector2d& pixel, double distance, double tilt_x,
                                    double tilt_y, double turn) {
  const Eigen::Vector3d ray = camera.ray(pixel);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(tilt_x, Eigen::Vector3d::UnitX()) *
                Eigen::AngleAxisd(tilt_y, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()))
                   .toRotationMatrix();
  T.translation() =
      distance * ray - T.linear() * Eigen::Vector3d(0.5 * board.width(), 0.5 * board.height(), 0);
  return T;
}

}  // namespace lcmslam::testing

#include <lcmslam/calibration/calibration_pictures.hpp>

#include <opencv2/imgproc.hpp>

#include <lcmslam/calibration/view_coverage.hpp>

namespace lcmslam {
namespace {

constexpr int picture_width = 640;  // pixels
constexpr double arrow_scale = 100;

/// A canvas on which a small image's pixels are enlarged.
class Canvas {
 public:
  explicit Canvas(const CameraModel& camera)
      : scale_(std::max(1.0, static_cast<double>(picture_width) / camera.width)),
        picture_(cvRound(scale_ * camera.height), cvRound(scale_ * camera.width), CV_8UC3,
                 cv::Scalar::all(255)) {
    for (int i = 1; i < ViewCoverage::cells; ++i) {
      const int x = picture_.cols * i / ViewCoverage::cells, y = picture_.rows * i / ViewCoverage::cells;
      cv::line(picture_, {x, 0}, {x, picture_.rows}, cv::Scalar::all(225));
      cv::line(picture_, {0, y}, {picture_.cols, y}, cv::Scalar::all(225));
    }
  }
  cv::Point at(const Eigen::Vector2d& pixel) const {
    return {cvRound(scale_ * (pixel.x() + 0.5)), cvRound(scale_ * (pixel.y() + 0.5))};
  }
  cv::Mat& picture() { return picture_; }
  void write(const std::string& text) {
    cv::putText(picture_, text, {8, picture_.rows - 10}, cv::FONT_HERSHEY_SIMPLEX, 0.5, cv::Scalar::all(60),
                1, cv::LINE_AA);
  }

 private:
  double scale_;
  cv::Mat picture_;
};

/// Colours that stay apart: the golden angle around the circle of hues.
cv::Scalar colour_of(std::size_t view) {
  cv::Mat hsv(1, 1, CV_8UC3, cv::Scalar(static_cast<double>((view * 69) % 180), 210, 190)), bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  return bgr.at<cv::Vec3b>(0, 0);
}

}  // namespace

cv::Mat coverage_picture(const CameraCalibration& calibration, const Board& board) {
  Canvas canvas(calibration.camera);
  for (std::size_t i = 0; i < calibration.views.size(); ++i) {
    const CalibratedView& c = calibration.views[i];
    const double w = board.width(), h = board.height();
    std::vector<cv::Point> outline;
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(w, 0, 0),
                                     Eigen::Vector3d(w, h, 0), Eigen::Vector3d(0, h, 0)})
      if (const auto pixel = calibration.camera.project(c.T_camera_board * p))
        outline.push_back(canvas.at(*pixel));
    cv::polylines(canvas.picture(), outline, true, colour_of(i), 1, cv::LINE_AA);
    for (const auto& p : c.view.pixels)
      cv::circle(canvas.picture(), canvas.at(p), 2, colour_of(i), -1, cv::LINE_AA);
  }
  canvas.write(std::to_string(calibration.views.size()) + " views");
  return canvas.picture();
}

cv::Mat residual_picture(const CameraCalibration& calibration) {
  Canvas canvas(calibration.camera);
  for (std::size_t i = 0; i < calibration.views.size(); ++i) {
    const CalibratedView& c = calibration.views[i];
    for (std::size_t k = 0; k < c.residuals.size(); ++k)
      cv::arrowedLine(canvas.picture(), canvas.at(c.view.pixels[k]),
                      canvas.at(c.view.pixels[k] + arrow_scale * c.residuals[k]), colour_of(i), 1,
                      cv::LINE_AA, 0, 0.2);
  }
  canvas.write("arrows are " + std::to_string(static_cast<int>(arrow_scale)) +
               " times as long as the errors");
  return canvas.picture();
}

}  // namespace lcmslam

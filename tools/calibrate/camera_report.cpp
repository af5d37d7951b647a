#include "tools/calibrate/camera_report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include <lcmslam/calibration/calibration_pictures.hpp>
#include <lcmslam/calibration/covariance_text.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include "tools/calibrate/units.hpp"

namespace lcmslam {
namespace {

void write_png(const cv::Mat& picture, const std::filesystem::path& file) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", picture, bytes);
  write_atomically(file, std::string(bytes.begin(), bytes.end()));
}

}  // namespace

std::vector<std::string> intrinsic_names(const CameraModel& camera) {
  std::vector<std::string> names = {"fx", "fy", "cx", "cy"};
  const char* coefficients[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  for (std::size_t i = 0; i < camera.distortion.size(); ++i) names.emplace_back(coefficients[i]);
  return names;
}

std::string camera_report(const CameraCalibration& c, const ViewCoverage& coverage) {
  const CameraModel& camera = c.camera;
  std::string text = fmt::format(
      "  focal length     fx {:.2f} +- {:.2f}, fy {:.2f} +- {:.2f} pixels ({:.2f} %)\n"
      "  principal point  cx {:.2f} +- {:.2f}, cy {:.2f} +- {:.2f} pixels\n",
      camera.fx, c.sigma(0), camera.fy, c.sigma(1), 100 * c.sigma(0) / camera.fx, camera.cx, c.sigma(2),
      camera.cy, c.sigma(3));
  const auto names = intrinsic_names(camera);
  text += "  distortion      ";
  for (std::size_t i = 4; i < names.size(); ++i)
    text += fmt::format("{} {} {:.4f} +- {:.4f}", i > 4 ? "," : "", names[i], camera.distortion[i - 4],
                        c.sigma(static_cast<int>(i)));
  text += camera.distortion.empty() ? " none that the views would show\n" : "\n";
  const auto worst = std::max_element(c.views.begin(), c.views.end(),
                                      [](const auto& a, const auto& b) { return a.rms < b.rms; });
  text += fmt::format(
      "  reprojection     {:.3f} pixels RMS over {} views; worst {:.3f} ({}); {} corners left out\n", c.rms,
      c.views.size(), worst->rms, worst->view.name, c.outliers);
  text += fmt::format(
      "  coverage         {:.0f} % of the image; tilts {:.0f} to {:.0f} degrees, {} views of 15 and more; "
      "{:.2f} to "
      "{:.2f} m\n",
      100 * coverage.filled(), degrees_per_rad * coverage.smallest_tilt,
      degrees_per_rad * coverage.largest_tilt, coverage.tilted_views, coverage.nearest, coverage.farthest);
  return text;
}

std::string camera_covariance(const CameraCalibration& calibration, const std::string& of) {
  return covariance_text(of, intrinsic_names(calibration.camera), calibration.covariance,
                         "Intrinsics that lcmslam calibrate estimated: pixels, distortion without unit.");
}

void write_pictures(const CameraCalibration& calibration, const Board& board, const std::string& folder) {
  if (folder.empty()) return;
  std::filesystem::create_directories(folder);
  write_png(coverage_picture(calibration, board), std::filesystem::path(folder) / "coverage.png");
  write_png(residual_picture(calibration), std::filesystem::path(folder) / "residuals.png");
}

}  // namespace lcmslam

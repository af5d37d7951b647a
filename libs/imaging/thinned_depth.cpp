#include <lcmslam/imaging/thinned_depth.hpp>

#include <limits>
#include <stdexcept>
#include <vector>

#include <lcmslam/imaging/inverse_depths.hpp>

namespace lcmslam {

DepthPoints::DepthPoints(const RgbdCalibration& calibration)
    : calibration_(calibration),
      geometry_(depth_row_geometry(calibration, calibration.T_colour_depth)),
      moves_(!calibration.T_colour_depth.matrix().isIdentity(0)),
      rays_(ray_table(calibration.depth)) {}

void DepthPoints::row(const RgbdFrame& frame, int row, int first, int columns, float* points,
                      float* sigma) const {
  unproject_row(frame.depth.ptr<std::uint16_t>(row) + first,
                frame.amplitude.empty() ? nullptr : frame.amplitude.ptr<std::uint8_t>(row) + first,
                rays_.ptr<float>(row) + 2 * first, columns, geometry_, points, sigma);
  if (moves_) move_row(columns, geometry_, points);
}

// All points are needed for the normals, one row at a time.
ThinnedDepth DepthPoints::thinned(const RgbdFrame& frame, int step) const {
  if (step < 1) throw std::invalid_argument("thinned depth: step must be at least 1");
  check_frame(frame, calibration_);
  const cv::Size size = rays_.size();
  ThinnedDepth result;
  result.step = step;
  result.rows = size.height;
  result.pitch = static_cast<float>(1 / calibration_.depth.fx);
  result.points.create((size.height + step - 1) / step, (size.width + step - 1) / step, CV_32FC3);
  result.sigma.create(result.points.size(), CV_32FC1);
  InverseDepths image(size);
  const auto width = static_cast<std::size_t>(size.width);
  std::vector<float> points(3 * width, std::numeric_limits<float>::quiet_NaN()), sigma(width, points[0]);
  for (int v = 0; v < size.height; ++v) {
    if (!frame.depth.empty()) row(frame, v, 0, size.width, points.data(), sigma.data());
    image.set_row(v, points.data(), size.width);
    if (v % step != 0) continue;
    auto* kept = result.points.ptr<cv::Vec3f>(v / step);
    auto* kept_sigma = result.sigma.ptr<float>(v / step);
    for (int u = 0; u < size.width; u += step) {
      const float* point = points.data() + 3 * static_cast<std::ptrdiff_t>(u);
      kept[u / step] = {point[0], point[1], point[2]};
      kept_sigma[u / step] = sigma[static_cast<std::size_t>(u)];
    }
  }
  result.normals = fit_normals(image, result.sigma, step, result.pitch);
  return result;
}

}  // namespace lcmslam

#include <lcmslam/calibration/view_coverage.hpp>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace lcmslam {
namespace {

constexpr double one_degree = M_PI / 180, enough_tilt = 15 * one_degree;
constexpr int fewest_tilted = 3;

std::string text(double value, int decimals) {
  std::ostringstream stream;
  stream << std::fixed << std::setprecision(decimals) << value;
  return stream.str();
}

bool is_empty(const ViewCoverage& coverage, int top, int left) {
  for (int row = top; row < top + ViewCoverage::cells / 2; ++row)
    for (int column = left; column < left + ViewCoverage::cells / 2; ++column)
      if (coverage.corners[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] > 0) return false;
  return true;
}

/// A quarter without any corner is missing; one whose outermost cell has none is missing its corner.
void look_for_gaps(const ViewCoverage& coverage, std::vector<std::string>& missing) {
  constexpr int half = ViewCoverage::cells / 2, last = ViewCoverage::cells - 1;
  const char* names[2][2] = {{"upper left", "upper right"}, {"lower left", "lower right"}};
  for (int down = 0; down < 2; ++down)
    for (int right = 0; right < 2; ++right) {
      const auto row = static_cast<std::size_t>(down * last), column = static_cast<std::size_t>(right * last);
      const std::string name = names[down][right];
      if (is_empty(coverage, down * half, right * half))
        missing.push_back("no corners in the " + name + " quarter of the image: hold the board there");
      else if (coverage.corners[row][column] == 0)
        missing.push_back("no corners in the image's " + name +
                          " corner, where the lens bends most: move the board farther out");
    }
}

void look_at_tilts(const ViewCoverage& coverage, std::vector<std::string>& missing) {
  if (coverage.tilted_views == 0)
    missing.push_back(
        "all views face-on (tilted by at most " + text(coverage.largest_tilt / one_degree, 0) +
        " degrees): tilt the board by 20 to 40 degrees, else focal length and distance are one");
  else if (coverage.tilted_views < fewest_tilted)
    missing.push_back("only " + std::to_string(coverage.tilted_views) +
                      " tilted views: add some, tilted by 20 to 40 degrees");
  else if (std::min(coverage.tilt_across, coverage.tilt_down) < enough_tilt)
    missing.push_back(std::string("the board was tilted about one axis only: tilt it ") +
                      (coverage.tilt_across < enough_tilt ? "up and down" : "to the left and right") +
                      ", too");
}

/// Pixels from the leftmost corner to the rightmost.
double width_of(const BoardView& view) {
  double left = 1e9, right = -1e9;
  for (const auto& p : view.pixels) left = std::min(left, p.x()), right = std::max(right, p.x());
  return right - left;
}

/// Both focal lengths', the less sure one's; relative.
double focal_sigma(const CameraCalibration& c) {
  return std::max(c.sigma(0) / c.camera.fx, c.sigma(1) / c.camera.fy);
}

}  // namespace

double ViewCoverage::filled() const {
  int count = 0;
  for (const auto& row : corners)
    count += static_cast<int>(std::count_if(row.begin(), row.end(), [](int n) { return n > 0; }));
  return static_cast<double>(count) / (cells * cells);
}

ViewCoverage coverage_of(const CameraCalibration& calibration, const Board& board) {
  ViewCoverage coverage;
  coverage.smallest_tilt = M_PI, coverage.nearest = 1e9;
  const CameraModel& camera = calibration.camera;
  const auto cell = [](double pixel, int size) {
    return static_cast<std::size_t>(
        std::clamp(static_cast<int>((pixel + 0.5) * ViewCoverage::cells / size), 0, ViewCoverage::cells - 1));
  };
  for (const CalibratedView& c : calibration.views) {
    coverage.largest = std::max(coverage.largest, width_of(c.view) / camera.width);
    for (const auto& p : c.view.pixels)
      ++coverage.corners[cell(p.y(), camera.height)][cell(p.x(), camera.width)];
    const Eigen::Vector3d normal = c.T_camera_board.linear().col(2);
    const double tilt = std::acos(std::clamp(std::abs(normal.z()), 0.0, 1.0));
    coverage.smallest_tilt = std::min(coverage.smallest_tilt, tilt);
    coverage.largest_tilt = std::max(coverage.largest_tilt, tilt);
    coverage.tilted_views += tilt >= enough_tilt ? 1 : 0;
    coverage.tilt_across = std::max(coverage.tilt_across, std::abs(std::atan2(normal.y(), normal.z())));
    coverage.tilt_down = std::max(coverage.tilt_down, std::abs(std::atan2(normal.x(), normal.z())));
    const Eigen::Vector3d middle =
        c.T_camera_board * Eigen::Vector3d(board.width() / 2, board.height() / 2, 0);
    coverage.nearest = std::min(coverage.nearest, middle.z());
    coverage.farthest = std::max(coverage.farthest, middle.z());
  }
  return coverage;
}

std::vector<std::string> missing_views(const CameraCalibration& calibration, const ViewCoverage& coverage,
                                       const CoverageLimits& limits) {
  std::vector<std::string> missing;
  const auto views = static_cast<int>(calibration.views.size());
  if (views < limits.fewest_views)
    missing.push_back("only " + std::to_string(views) + " views with the board: at least " +
                      std::to_string(limits.fewest_views) + ", better 20");
  look_for_gaps(coverage, missing);
  look_at_tilts(coverage, missing);
  const double sigma = focal_sigma(calibration);
  if (missing.empty() && !(sigma < limits.focal_sigma))
    missing.push_back("the focal length is known to " + text(100 * sigma, 2) + " % only (must be below " +
                      text(100 * limits.focal_sigma, 2) +
                      " %): add views, nearer and tilted, in which the board fills the image");
  if (calibration.rms > limits.rms)
    missing.push_back("the corners lie " + text(calibration.rms, 2) +
                      " pixels beside where they should (at most " + text(limits.rms, 2) +
                      "): is the board flat, are its columns, rows and kind right, are images blurred?");
  return missing;
}

// A view tells the focal length by how differently near and far corners of a tilted board are spaced: the
// larger it is in the image and the more tilted, the more. Of views like those there are, n halve the error
// of n / 4.
std::vector<std::string> wanted_views(const CameraCalibration& calibration, const ViewCoverage& coverage,
                                      const CoverageLimits& limits) {
  const double sigma = focal_sigma(calibration);
  if (sigma <= limits.wanted_sigma) return {};
  constexpr double large = 0.6;  // of the image's width
  const auto views = static_cast<double>(calibration.views.size());
  const double as_many = sigma / limits.wanted_sigma;
  const std::string known = "the focal length is known to " + text(100 * sigma, 2) + " % (one sigma; " +
                            text(100 * limits.wanted_sigma, 2) + " % is wanted): ";
  if (coverage.largest < large)
    return {known + "hold the board nearer, so that it fills the image, and tilted by 20 to 40 degrees"};
  if (2 * coverage.tilted_views < static_cast<int>(calibration.views.size()))
    return {known + "tilt the board by 20 to 40 degrees, near enough to fill the image"};
  return {known + "some " + text(std::ceil(views * (as_many * as_many - 1)), 0) +
          " more views, near and tilted by 20 to 40 degrees"};
}

}  // namespace lcmslam

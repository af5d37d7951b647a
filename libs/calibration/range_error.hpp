#pragma once
// What a depth camera's ranges err by, from a board whose plane is known: offset and wiggle
// (imaging/depth_error.hpp).

#include <lcmslam/calibration/board_view.hpp>
#include <lcmslam/imaging/depth_error.hpp>

namespace lcmslam {

/// Ranges of one view that lie within two centimetres, put together.
struct RangeSample {
  double range = 0;  ///< m, true, along the ray
  double error = 0;  ///< m, measured less true: the median of its pixels
  double sigma = 0;  ///< m, of the median, and of its share in the board's distance
};

/// How sure the distance (m) of a board is that `camera` places by its corners, which are a tenth of a pixel
/// beside where they should be, all alike (blur, light): z = f W / w.
double board_distance_sigma(const CameraModel& camera, const Board& board, double distance);

/// m: farther off is something before the board, not its range.
constexpr double gross_range_error = 0.3;

/// The depth image's pixels on the board against its plane, but for gross errors. `depth` CV_16UC1 mm along
/// the optical axis; pixels within two of the board's rim are left out, they see beside it too. `pose_sigma`
/// (m) of the board's distance, which all pixels share: all samples together tell the mean error no better
/// than that. Throws std::invalid_argument for another image.
std::vector<RangeSample> board_ranges(const cv::Mat& depth, const CameraModel& camera, const Board& board,
                                      const Eigen::Isometry3d& T_camera_board, double pose_sigma);

struct RangeErrorFitSettings {
  /// A phase measurement's scale is its clock's, exact to millionths: what looks like a scale is the focal
  /// length's error, which moves the board. It is estimated, so that it does not bend the wiggle, and then
  /// thrown away, unless:
  bool keep_scale = false;
  /// Standard deviation of that apparent scale before anything is seen: the focal length's relative one. Not
  /// used where the scale is kept.
  double scale_sigma = 0.002;
};

struct RangeErrorFit {
  DepthError error;
  /// Of offset (m), scale, wiggle (m), period (m), phase (rad); zero where a value was not estimated.
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  double apparent_scale = 0;             ///< as estimated, kept or not
  double nearest = 0, farthest = 0;      ///< m, of the samples
  double rms_before = 0, rms_after = 0;  ///< m, of the samples, as measured and corrected by `error`
  std::vector<std::string> notes;        ///< what could not be observed, and why
};

/// Throws std::invalid_argument for less than ten samples; it says why there may be so few.
RangeErrorFit fit_range_error(const std::vector<RangeSample>& samples,
                              const RangeErrorFitSettings& settings = {});

}  // namespace lcmslam

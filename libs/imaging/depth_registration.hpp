#pragma once
// Brings the depth camera's measurements into the colour camera.

#include <vector>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/depth_tiles.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

/// Point image of the depth camera, and what the colour camera sees at those points.
struct RegisteredDepth {
  cv::Mat points;       ///< CV_32FC3, depth image's size, points in the colour camera frame at the colour
                        ///< image's time, NaN where invalid
  cv::Mat sigma;        ///< CV_32FC1, depth standard deviation in m, NaN where invalid
  cv::Mat pixels;       ///< CV_32FC2, position in the (distorted) colour image, NaN where outside or occluded
  float pitch = 0;      ///< angle between neighbouring depth pixels, rad (1 / focal length)
  float footprint = 1;  ///< colour pixels between neighbouring depth pixels
  bool aligned = false;  ///< depth pixel (u, v) is colour pixel (u, v)
};

/// Depth seen at a colour pixel: the 3-D point in the colour camera frame, m, and its depth's
/// standard deviation, m. All NaN where there is no depth around the pixel or where the neighbours
/// disagree by more than their noise (a depth edge).
struct DepthAtPixel {
  Eigen::Vector3f point;
  float sigma;
};

/// Throws std::invalid_argument, with both sizes, when an image is not of the calibration's size.
void check_frame(const RgbdFrame& frame, const RgbdCalibration& calibration);

/// Brings depth images into the colour camera; keeps the tables that depend on the calibration alone.
class DepthRegistration {
 public:
  /// Throws std::invalid_argument when the calibration does not pass check().
  explicit DepthRegistration(RgbdCalibration calibration);

  /// `T_colour_depth_time` moves the colour camera's frame from the depth image's time to the colour
  /// image's time (identity when the motion is not known): x_at_colour_time = T * x_at_depth_time, that
  /// is T_camera(colour)_world * T_world_camera(depth). The depth stamp to look the motion up at is
  /// calibration.depth_time(frame.depth_utime).
  /// A depth point that another one hides from the colour camera has no pixel (z-buffer). A frame
  /// without depth gives points that are all NaN. Pixels are looked up at every `pixel_step`-th row and
  /// column, for those who thin the cloud (looking them up is most of the cost), the others are NaN.
  /// Throws std::invalid_argument when the depth image does not have the calibration's size.
  RegisteredDepth operator()(const RgbdFrame& frame,
                             const Eigen::Isometry3d& T_colour_depth_time = Eigen::Isometry3d::Identity(),
                             int pixel_step = 1) const;

  /// The depth image alone, before any motion is known: points in the colour camera's frame as it stood at
  /// the depth image's time, `pixels` empty. Throws as the other one.
  RegisteredDepth unproject(const RgbdFrame& frame) const;

  /// What depth_at_pixels() says of the whole registered image, bit for bit, but only what lies around these
  /// pixels is registered. Throws as the other ones.
  std::vector<DepthAtPixel> depth_at_pixels(
      const RgbdFrame& frame, const std::vector<cv::Point2f>& colour_pixels,
      const Eigen::Isometry3d& T_colour_depth_time = Eigen::Isometry3d::Identity()) const;

  const RgbdCalibration& calibration() const { return calibration_; }

 private:
  RegisteredDepth unproject(const RgbdFrame& frame, const Eigen::Isometry3d& T) const;

  RgbdCalibration calibration_;
  cv::Mat rays_;  // of the depth camera, CV_32FC2
  DepthTiles tiles_;
};

/// The same without keeping tables: for single frames.
RegisteredDepth register_depth(const RgbdFrame& frame, const RgbdCalibration& calibration,
                               const Eigen::Isometry3d& T_colour_depth_time = Eigen::Isometry3d::Identity());

/// Unit normals towards the camera at every `step`-th row and column of a point image, CV_32FC3 of size
/// ceil(rows / step) x ceil(cols / step). A plane is fitted to up to 25 neighbours whose distance grows
/// with the noise; NaN where there is no point, at depth edges, and where noise or a grazing view leave
/// the normal uncertain by more than 0.3 rad.
cv::Mat estimate_normals(const RegisteredDepth& registered, int step = 1);

/// 3-D points of sub-pixel positions in the (distorted) colour image: each is interpolated by a plane
/// through the registered depth points within 1.5 depth pixels of it.
std::vector<DepthAtPixel> depth_at_pixels(const RegisteredDepth& registered,
                                          const RgbdCalibration& calibration,
                                          const std::vector<cv::Point2f>& colour_pixels);

}  // namespace lcmslam

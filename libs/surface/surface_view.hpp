#pragma once
// A camera frame as the surface takes it: each pixel is a small plane with a weight and a colour.
//
// The distance of a voxel from the surface is its distance from the plane of the pixel that sees it, not
// along the ray: so slanted surfaces are neither thickened nor do they step from pixel to pixel.

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/surface/lens.hpp>
#include <lcmslam/surface/surface_settings.hpp>

namespace lcmslam {

/// What is kept of a frame: small images of the same size, of the depth camera's view.
struct SurfaceImage {
  cv::Mat depth;      ///< CV_16UC1 mm along the optical axis, 0 = invalid
  cv::Mat amplitude;  ///< CV_8UC1 or empty
  cv::Mat colour;     ///< CV_8UC3 BGR, what the colour camera sees where the pixel's ray ends
  cv::Mat seen;       ///< CV_8UC1, 255 where it sees it; 0: hidden, or outside its image
  Eigen::Isometry3d T_camera_depth = Eigen::Isometry3d::Identity();  ///< to the colour camera
};

/// A small plane in the depth camera's frame: normal . point + offset is the distance from it, positive on
/// the camera's side.
struct SurfacePixel {
  static constexpr std::uint8_t coloured = 128;

  std::array<float, 4> plane{};          ///< unit normal towards the camera, and offset in m
  std::array<std::uint8_t, 3> colour{};  ///< BGR
  /// In units of VoxelBlock::weight, 0: nothing was seen; and the bit `coloured` where the colour is known.
  std::uint8_t look = 0;
};

struct SurfaceView {
  CameraModel camera;
  Lens lens;
  std::vector<SurfacePixel> pixels;  ///< rows x columns, and one that saw nothing
  std::vector<float> depth;          ///< m, 0 where nothing was seen
  cv::Mat points, normals;           ///< CV_32FC3 of the image's size, m and unit; NaN where unknown

  static constexpr int tile = 8;  ///< pixels
  cv::Mat_<float> farthest;       ///< m, of each tile of pixels; 0 where none has depth
  cv::Mat_<float> flattest;       ///< likewise: how far 1 m behind the surface is along the optical axis

  std::size_t at(int v, int u) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u);
  }
};

class SurfaceViewMaker {
 public:
  /// Throws std::invalid_argument for a calibration that does not pass check().
  SurfaceViewMaker(const RgbdCalibration& calibration, const SurfaceSettings& settings);

  /// Large images are halved: voxels are not smaller than such pixels. The frame's depth should have passed
  /// DepthFilter. `T_colour_depth_time` as for DepthRegistration. Throws std::invalid_argument for images
  /// that are not of the calibration's size.
  SurfaceImage image(const RgbdFrame& frame,
                     const Eigen::Isometry3d& T_colour_depth_time = Eigen::Isometry3d::Identity()) const;

  /// The same for the same image, whenever it is asked.
  SurfaceView view(const SurfaceImage& image) const;

 private:
  RgbdCalibration full_, small_;
  DepthRegistration to_depth_;  // of small images, without leaving the depth camera's frame
  Lens colour_lens_, depth_lens_;
  SurfaceSettings settings_;
};

}  // namespace lcmslam

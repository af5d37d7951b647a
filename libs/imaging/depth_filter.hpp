#pragma once
// Takes out of a depth image what no surface gave: mixed (flying) pixels at depth edges, pixels too dark to
// be believed, specks. Works on the image as it came, before anything is registered or thinned.
//
// A filter is a row of parts, applied in order; each takes pixels out (sets them to 0) or smooths them.
//   DepthFilter filter(calibration);
//   filter(frame.depth, frame.amplitude);
// `lcmslam study --only depth-filter` measures it against the simulation's truth.

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// A depth image on its way through the parts. `inverse` has a border of invalid pixels, so that look at
/// neighbours without asking where the image ends; they follow `depth`.
struct DepthImage {
  static constexpr int border = 4;  ///< pixels on each side

  cv::Mat depth;             ///< CV_16UC1 mm along the optical axis, 0 = invalid
  cv::Mat amplitude;         ///< CV_8UC1 or empty
  cv::Mat_<float> inverse;   ///< 1/m, 0 where invalid. A plane's inverse depth is linear over the image.
  cv::Mat_<float> sigma;     ///< 1/m, standard deviation of `inverse` by the calibration's noise
  bool independent = false;  ///< pixels' errors do not depend on their neighbours'
  float pitch_x = 0, pitch_y = 0;  ///< rad between neighbouring columns and rows

  const float* inverse_row(int v) const { return inverse.ptr<float>(v + border) + border; }
  float* inverse_row(int v) { return inverse.ptr<float>(v + border) + border; }
  const float* sigma_row(int v) const { return sigma.ptr<float>(v); }
};

class DepthFilterPart {
 public:
  virtual ~DepthFilterPart() = default;
  /// May keep buffers: one object serves one thread. Leaves `inverse` 0 where depth is 0.
  virtual void apply(DepthImage& image) = 0;
  /// Standard deviation of a pixel on a surface afterwards, over that before, where pixels are independent:
  /// below 1 for parts that smooth.
  virtual double noise_left() const { return 1; }
};

struct AmplitudeFilterSettings {
  double min_amplitude = 0.02;

  void describe(SettingsVisitor& s) {
    s.number("min_amplitude", min_amplitude, "", {0, 1},
             "of the brightest; darker pixels go (no effect without an amplitude image)");
  }
};

/// A surface goes on from a pixel to its neighbour when their inverse depths differ by no more than the noise
/// and the slope explain. The slope is that of the neighbour's own side (over `reach` pixels), freed of what
/// noise alone would give it, and no steeper than max_incidence; slopes up to free_incidence are granted
/// without being seen. Slopes are tangents times the pixel pitch, so one set holds for every resolution.
/// A pixel stays when its surface goes on to the left or right and also up or down: a mixed pixel may find
/// others like itself along the edge, but not across it.
struct JumpEdgeFilterSettings {
  double noise_sigmas = 1.35;
  double free_incidence = 0.46;
  double max_incidence = 1.4;

  void describe(SettingsVisitor& s) {
    s.number("noise_sigmas", noise_sigmas, "", {0, 1000}, "of a difference that noise may explain");
    s.number("free_incidence", free_incidence, "rad", {0, 1.57},
             "slope that is granted without being seen, from the viewing ray to the normal");
    s.number("max_incidence", max_incidence, "rad", {0, 1.57}, "steepest slope that is granted");
  }
};

struct SpeckleFilterSettings {
  double min_solid_angle = 1e-4;

  void describe(SettingsVisitor& s) {
    s.number("min_solid_angle", min_solid_angle, "sr", {0, 1},
             "connected valid pixels that cover less go (1e-4 sr: 4 cm^2 at 2 m)");
  }
};

/// Weighted mean over 5 x 5 pixels (rows, then columns), weights falling with the difference over the noise.
/// Whatever a sensor invents at edges must be gone before. Only for ToF cameras, which measure each pixel by
/// itself (depth_noise.amplitude > 0): structured light matches windows of pixels, so neighbours share their
/// errors, a mean takes nothing away, and small shapes suffer.
struct BilateralFilterSettings {
  double range_sigmas = 3;

  void describe(SettingsVisitor& s) {
    s.number("range_sigmas", range_sigmas, "", {0.1, 1000}, "of a difference; farther ones have no weight");
  }
};

struct DepthFilterSettings {
  std::vector<std::string> parts = {"amplitude", "jump_edges", "speckle", "bilateral"};
  AmplitudeFilterSettings amplitude;
  JumpEdgeFilterSettings jump_edges;
  SpeckleFilterSettings speckle;
  BilateralFilterSettings bilateral;

  void describe(SettingsVisitor& s) {
    s.texts("parts", parts, "what is done to a depth image, in this order; [] is no filter",
            {"amplitude", "jump_edges", "speckle", "bilateral"});
    s.section("amplitude", amplitude, "takes out pixels too dark to be believed");
    s.section("jump_edges", jump_edges, "takes out mixed pixels at depth edges");
    s.section("speckle", speckle, "takes out specks");
    s.section("bilateral", bilateral, "smooths what edges leave (only cameras with amplitude noise)");
  }
};

class DepthFilter {
 public:
  /// Throws std::invalid_argument for settings that are wrong.
  explicit DepthFilter(const RgbdCalibration& calibration, const DepthFilterSettings& settings = {});

  /// Filters in place. `depth` CV_16UC1 mm of any size, `amplitude` CV_8UC1 of the same size or empty; throws
  /// std::invalid_argument for others. Takes no memory after the first image of a size.
  void operator()(cv::Mat& depth, const cv::Mat& amplitude);

  /// Standard deviation of a pixel on a surface after the filter, over that before. Neighbours share what is
  /// left, and at edges, where they are missing, more is.
  double noise_left() const;

 private:
  void prepare();

  DepthNoise noise_;
  std::vector<std::unique_ptr<DepthFilterPart>> parts_;
  DepthImage image_;
};

}  // namespace lcmslam

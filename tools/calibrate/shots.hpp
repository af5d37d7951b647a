#pragma once
// The images that a camera is calibrated from: files of a folder, frames of a log, or what comes over the
// bus.

#include <CLI/CLI.hpp>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// Grey images (CV_8UC1) of one moment, depth CV_16UC1 mm as it came; empty where there is none.
struct Shot {
  std::string name;
  cv::Mat colour, amplitude, depth;
};

struct ShotInput {
  std::string path;  ///< folder or .lcmlog
  bool live = false;
  std::string lcm_url;
  double seconds = 0;   ///< of listening; 0: until there is enough, or Ctrl-C
  double every = 0.25;  ///< s between shots of a log or the bus

  void add_to(CLI::App& app);
  /// Images of a folder were chosen by somebody; frames of a camera that runs are to be chosen from.
  bool is_sequence() const;
};

/// Hands over one shot after the other, until `use` gives false. Gives the calibration that the log or the
/// bus tells of the camera, if any. A folder holds images, or the folders colour, amplitude and depth with
/// files of the same names. Throws std::runtime_error when there are no images, and what `use` throws.
std::optional<RgbdCalibration> read_shots(const ShotInput& input,
                                          const std::function<bool(const Shot&)>& use);

/// Images of two sizes are of two cameras.
class OneCamera {
 public:
  /// Throws std::runtime_error for an image of another size than the first.
  void check(const std::string& name, const cv::Size& size);
  /// Empty before the first.
  const cv::Size& size() const { return size_; }

 private:
  cv::Size size_;
};

/// "3 views", for whoever holds the board before a camera that runs.
void tell_views(std::size_t views);

}  // namespace lcmslam

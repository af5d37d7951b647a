#pragma once
// Recorded colour and depth images from folders, whatever their layout: TUM RGB-D (also ICL-NUIM),
// 7-Scenes, or numbered files that a small YAML describes.
//
//   auto source = open_dataset("../shared/data/tum_fr1_rpy");
//   for (const std::string& note : source->notes()) ...          // what was assumed
//   for (std::size_t i = 0; i < source->size(); ++i)
//     if (auto frame = source->frame(i)) publish(*frame);        // else: problems() has grown

#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

/// A folder that is no data set: names the folder or file and what would be right.
class DatasetError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class RgbdSource {
 public:
  struct Entry {
    Utime utime = 0;        ///< of the colour image
    Utime depth_utime = 0;  ///< of the depth image
  };

  virtual ~RgbdSource() = default;
  virtual const RgbdCalibration& calibration() const = 0;

  /// Frames in order of time, those of the listing; some may turn out unreadable.
  virtual std::size_t size() const = 0;
  virtual Entry entry(std::size_t index) const = 0;

  /// Reads one frame, ready for the wire: a JPEG passes through as it is, other colour images become
  /// JPEG, depth becomes zlib millimetres; seq is the index. Nothing when a file is missing, damaged or
  /// of the wrong size: then problems() names it.
  virtual std::optional<EncodedFrame> frame(std::size_t index) = 0;

  /// True poses, sorted by time; empty when the data set has none.
  virtual const Trajectory& truth() const = 0;
  /// The body whose poses they are: "camera" (the colour camera's optical frame) or "robot".
  virtual const std::string& truth_frame() const = 0;

  /// What was assumed because the data do not say it ("no stamps: 30 Hz assumed").
  virtual const std::vector<std::string>& notes() const = 0;
  /// What is missing or malformed, each beginning with the file's name; grows as frames are read.
  virtual const std::vector<std::string>& problems() const = 0;
};

struct DatasetOptions {
  std::filesystem::path calibration;    ///< overrides the data set's own; empty: look for it
  std::filesystem::path description;    ///< dataset YAML (keys: config/datasets/*.yaml); empty: look for it
  std::filesystem::path config_folder;  ///< holds datasets/ and calibration/; empty: share_path("config")
  int jpeg_quality = 90;                ///< for colour images that are not JPEG yet
};

/// Opens a folder. How it is laid out is said by, in this order: options.description, lcmslam.yaml in
/// the folder, the first of config/datasets/*.yaml (by name) whose files are there. Intrinsics come from
/// options.calibration, calibration.yaml in the folder, or the description. Throws DatasetError or
/// ConfigError.
std::unique_ptr<RgbdSource> open_dataset(const std::filesystem::path& folder,
                                         const DatasetOptions& options = {});

}  // namespace lcmslam

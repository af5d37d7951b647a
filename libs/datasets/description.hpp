#pragma once
// How a data set is laid out: the small YAML beside the data or in config/datasets.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <lcmslam/datasets/dataset.hpp>

namespace lcmslam {

/// One format's settings; the keys are documented in config/datasets/*.yaml.
struct Description {
  std::filesystem::path file;          ///< where it was read
  std::string format;                  ///< "tum", "seven_scenes" or "numbered"
  double depth_scale = 1000;           ///< value of a depth pixel at 1 m
  double frame_rate = 30;              ///< Hz, where there are no stamps; names that are ns: 1e9
  double max_stamp_difference = 0.02;  ///< s between a colour and its depth image
  std::string truth_of = "colour";     ///< poses are of the "colour" or "depth" camera or the "robot"
  std::string colour, depth;           ///< numbered files, like image/%05d.jpg
  std::string stamps;                  ///< file with one stamp (s) a frame, or colour's and depth's; or empty
  std::string poses;                   ///< file, or empty
  std::string pose_format;             ///< see pose_files.hpp
  std::filesystem::path calibration;   ///< or empty
  /// Calibration by a word in the recording's name (TUM names its sequences after the camera).
  std::vector<std::pair<std::string, std::filesystem::path>> calibration_by_name;
};

/// Throws ConfigError.
Description read_description(const std::filesystem::path& file);

/// Whether the folder holds the files that the description speaks of.
bool matches(const Description& description, const std::filesystem::path& folder);

/// The folder's description, as open_dataset explains. Throws DatasetError when none fits.
Description find_description(const std::filesystem::path& folder, const DatasetOptions& options,
                             const std::filesystem::path& config_folder);

}  // namespace lcmslam

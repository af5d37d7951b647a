#pragma once
// The readers: each lists a folder's frames and true poses. They throw DatasetError when there is no
// frame at all.

#include <filesystem>
#include <functional>

#include <lcmslam/datasets/description.hpp>
#include <lcmslam/datasets/recording.hpp>

namespace lcmslam {

/// The calibration of a recording; what it finds on the way is noted in there.
using CalibrationOf = std::function<const RgbdCalibration&(Recording&)>;

/// rgb.txt and depth.txt, whose stamps pair them on colour's clock, or associations.txt.
bool is_tum(const std::filesystem::path& folder);
Recording read_tum_folder(const std::filesystem::path& folder, const Description& description,
                          const CalibrationOf& calibration_of);

/// frame-000000.color.png|jpg here or in seq-01, seq-02, ...
bool is_seven_scenes(const std::filesystem::path& folder);
Recording read_seven_scenes(const std::filesystem::path& folder, const Description& description);

/// Files by patterns.
Recording read_numbered_files(const std::filesystem::path& folder, const Description& description);

/// "no stamps: 30 Hz assumed".
std::string frame_rate_note(const Description& description);

}  // namespace lcmslam

#pragma once
// Files of true poses. Bad poses are reported and left out; the others are kept.
//   tum          stamp tx ty tz qx qy qz qw        a line, s and m
//   quaternions  tx ty tz qx qy qz qw              a line, frame after frame
//   matrices     12 or 16 numbers, row by row      a line, frame after frame
//   log          blocks: a line "i j k" (i counts frames from 0), then four lines of a 4x4 matrix

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/datasets/recording.hpp>

namespace lcmslam {

/// Poses T_world_body by stamp. Throws DatasetError when the file cannot be read.
void read_stamped_poses(const std::filesystem::path& file, Recording& recording);

/// Poses frame after frame; time_of gives the stamp of the n-th frame (from 0), or nothing.
void read_counted_poses(const std::filesystem::path& file, const std::string& format,
                        const std::function<std::optional<Utime>(long)>& time_of, Recording& recording);

/// One 4x4 matrix in a file of its own (7-Scenes).
void read_pose_file(const std::filesystem::path& file, Utime utime, Recording& recording);

}  // namespace lcmslam

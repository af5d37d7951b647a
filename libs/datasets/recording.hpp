#pragma once
// What a reader finds in a folder, before any image is opened.

#include <filesystem>
#include <string>
#include <vector>

#include <lcmslam/datasets/dataset.hpp>

namespace lcmslam {

struct FrameFiles {
  Utime utime = 0;
  Utime depth_utime = 0;
  std::filesystem::path colour;
  std::filesystem::path depth;
};

struct Recording {
  std::vector<FrameFiles> frames;
  Trajectory truth;
  std::string name_in_files;  ///< what the files call the recording, empty if nothing
  std::vector<std::string> notes;
  std::vector<std::string> problems;
};

}  // namespace lcmslam

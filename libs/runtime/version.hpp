#pragma once

namespace lcmslam {

/// Of the project in CMakeLists.txt, "1.2.3": programs, logs and summaries all show this one.
extern const char* const lcmslam_version;

}  // namespace lcmslam

#include <lcmslam/runtime/version.hpp>

namespace lcmslam {

const char* const lcmslam_version = LCMSLAM_VERSION;

}  // namespace lcmslam

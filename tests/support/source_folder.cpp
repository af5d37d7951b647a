#include "tests/support/source_folder.hpp"

namespace lcmslam {

std::filesystem::path source_folder() {
  return LCMSLAM_SOURCE_DIR;
}

}  // namespace lcmslam

#include "procs/camera/drivers/open_driver.hpp"

namespace lcmslam {

const bool has_openni2 = false;

std::unique_ptr<CameraDevice> open_openni2(const OpenNi2Settings&, const WantedImages&) {
  require_driver("openni2");
  return nullptr;
}

}  // namespace lcmslam

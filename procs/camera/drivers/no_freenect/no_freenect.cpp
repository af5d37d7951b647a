#include "procs/camera/drivers/open_driver.hpp"

namespace lcmslam {

const bool has_freenect = false;

std::unique_ptr<CameraDevice> open_freenect(const FreenectSettings&, const WantedImages&) {
  require_driver("freenect");
  return nullptr;
}

}  // namespace lcmslam

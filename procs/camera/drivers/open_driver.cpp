#include "procs/camera/drivers/open_driver.hpp"

namespace lcmslam {

void require_driver(const std::string& driver) {
  const auto missing = [](const std::string& name, const std::string& package) {
    throw DriverMissing("this build has no " + name + ": install " + package +
                        " (Debian: sudo apt-get install " + package +
                        "), remove build/release/CMakeCache.txt, " + "and build again");
  };
  if (driver == "openni2" && !has_openni2) missing("OpenNI2", "libopenni2-dev");
  if (driver == "freenect" && !has_freenect) missing("libfreenect", "libfreenect-dev");
}

std::unique_ptr<CameraDevice> open_driver(const DriverSettings& settings, const WantedImages& wanted) {
  require_driver(settings.driver);
  if (settings.driver == "openni2") return open_openni2(settings.openni2, wanted);
  if (settings.driver == "freenect") return open_freenect(settings.freenect, wanted);
  return open_video(settings.video);
}

}  // namespace lcmslam

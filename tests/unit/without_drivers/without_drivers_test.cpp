// The drivers as a build has them that found neither OpenNI2 nor libfreenect.

#include <gmock/gmock.h>

#include "procs/camera/drivers/open_driver.hpp"

namespace lcmslam {
namespace {

std::string refusal(const std::string& driver) {
  DriverSettings settings;
  settings.driver = driver;
  try {
    open_driver(settings, {});
  } catch (const DriverMissing& error) {
    return error.what();
  }
  return "";
}

TEST(WithoutDrivers, SaysWhatToInstall) {
  EXPECT_FALSE(has_openni2);
  EXPECT_FALSE(has_freenect);
  EXPECT_THAT(refusal("openni2"), ::testing::HasSubstr("install libopenni2-dev"));
  EXPECT_THAT(refusal("freenect"), ::testing::HasSubstr("install libfreenect-dev"));
}

}  // namespace
}  // namespace lcmslam

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include <lcmslam/fastslam/fastslam.hpp>

namespace lcmslam {
namespace {

std::string complaint(const FastSlamSettings& settings) {
  try {
    check(settings);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(FastSlamSettings, PresetsAreValid) {
  EXPECT_EQ(complaint(FastSlamSettings()), "");
  EXPECT_EQ(complaint(thesis_preset()), "");
}

TEST(FastSlamSettings, ErrorsNameSettingAndValue) {
  FastSlamSettings settings;
  settings.particles = 0;
  EXPECT_NE(complaint(settings).find("particles is 0, must be"), std::string::npos);
  settings = FastSlamSettings();
  settings.gate = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(complaint(settings).find("gate"), std::string::npos);
  settings = FastSlamSettings();
  settings.guided = false;
  EXPECT_NE(complaint(settings).find("verify_by_consensus"), std::string::npos);
  settings = FastSlamSettings();
  settings.maximum_range = 0.1;  // below the minimum
  EXPECT_NE(complaint(settings).find("maximum_range is 0.1 m"), std::string::npos);
  EXPECT_THROW(FastSlam{settings}, std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

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

// What the matchers refuse would stop the filter at its second step.
TEST(FastSlamSettings, NothingIsMatchedByDescriptorsThatMustBeTheSame) {
  FastSlamSettings settings;
  settings.descriptor_ratio = 0;
  EXPECT_NE(complaint(settings).find("descriptor_ratio is 0, must be"), std::string::npos);
  settings = FastSlamSettings();
  settings.descriptor_distance = 0;
  EXPECT_NE(complaint(settings).find("descriptor_distance is 0, must be"), std::string::npos);
}

}  // namespace
}  // namespace lcmslam

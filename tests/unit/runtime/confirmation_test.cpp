#include <lcmslam/runtime/confirmation.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

command_t command(const std::string& name,
                  const std::vector<std::pair<std::string, std::string>>& words = {}) {
  command_t c;
  c.name = name;
  for (const auto& [key, value] : words) {
    c.keys.push_back(key);
    c.values.push_back(value);
  }
  c.n = static_cast<int32_t>(c.keys.size());
  return c;
}

TEST(Confirmation, IsNeededForWhatEndsAProcessOrForgetsItsMap) {
  for (const char* name : {"stop", "reset"}) EXPECT_TRUE(needs_confirmation(command(name))) << name;
  for (const char* name : {"save", "resend", "smooth", ""})
    EXPECT_FALSE(needs_confirmation(command(name))) << name;
}

TEST(Confirmation, IsTheProcessWithTheSenderOfThisRun) {
  EXPECT_TRUE(is_confirmed(command("reset", {{"icp", "-5"}}), "icp", -5));
  EXPECT_TRUE(is_confirmed(command("reset", {{"fastslam", "7"}, {"icp", "-5"}}), "icp", -5));
  EXPECT_FALSE(is_confirmed(command("reset"), "icp", -5));
  EXPECT_FALSE(is_confirmed(command("reset", {{"icp", "5"}}), "icp", -5)) << "an earlier run's";
  EXPECT_FALSE(is_confirmed(command("reset", {{"fastslam", "-5"}}), "icp", -5)) << "another process's";
  EXPECT_FALSE(is_confirmed(command("reset", {{"icp", ""}}), "icp", 0));
  command_t torn = command("reset", {{"icp", "-5"}});
  torn.values.clear();
  EXPECT_FALSE(is_confirmed(torn, "icp", -5));
}

}  // namespace
}  // namespace lcmslam

#include "tools/above_zero.hpp"

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

TEST(AboveZero, RefusesInAFewWords) {
  for (std::string good : {"0.1", "3", "1e300"}) EXPECT_EQ(above_zero()(good), "");
  for (std::string bad : {"0", "-3", "nan", "inf", "three"})
    EXPECT_EQ(above_zero()(bad), bad + " is no number above 0");
}

}  // namespace
}  // namespace lcmslam

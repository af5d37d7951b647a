#include <gtest/gtest.h>

#include <cstdio>

#include <lcmslam/files/decimal_text.hpp>

namespace lcmslam {
namespace {

TEST(DecimalText, WritesAsPrintfDoesInTheCLocale) {
  for (const double number : {0.0, -1.5, 1234.56789, 1e-7, -3.25e300, 1e300, 0.1, 2.0 / 3}) {
    char expected[400];
    std::string fixed = "x ", general = "x ";
    append_fixed(fixed, number, 6);
    std::snprintf(expected, sizeof expected, "x %.6f", number);
    EXPECT_EQ(fixed, expected);
    append_general(general, number, 9);
    std::snprintf(expected, sizeof expected, "x %.9g", number);
    EXPECT_EQ(general, expected);
  }
}

}  // namespace
}  // namespace lcmslam

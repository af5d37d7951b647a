#include <lcmslam/evaluation/table.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

namespace lcmslam {
namespace {

TEST(Table, AlignsNamesLeftAndNumbersRight) {
  Table table({"method", "ATE m", "n"});
  table.add({"wheels", fixed_number(0.12345, 3), "7"});
  table.add({"fastslam", fixed_number(std::numeric_limits<double>::quiet_NaN(), 3), "1200"});
  std::ostringstream text;
  text << table;
  EXPECT_EQ(text.str(),
            "method    ATE m     n\n"
            "--------  -----  ----\n"
            "wheels    0.123     7\n"
            "fastslam      -  1200\n");
}

TEST(Table, CountsCharactersNotBytes) {
  Table table({"σ", "b"});
  table.add({"½µ", "1"});
  EXPECT_EQ(table.text(), "σ   b\n--  -\n½µ  1\n");
}

TEST(Table, RowsMustFitTheHeader) {
  Table table({"a", "b"});
  EXPECT_THROW(table.add({"1"}), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

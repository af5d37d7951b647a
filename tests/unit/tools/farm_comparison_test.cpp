// Two farms against each other.

#include <gmock/gmock.h>
#include <cmath>
#include <filesystem>
#include <functional>

#include <lcmslam/geometry/random.hpp>
#include "tests/unit/tools/farm_fixture.hpp"
#include "tools/farm/farm_comparison.hpp"
#include "tools/farm/farm_report.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using testing::Farm;
using ::testing::HasSubstr;

TEST_F(Farm, AComparisonNamesTheLogsThatAreInNoRatio) {
  std::vector<FarmResult> before, after;
  for (int i = 0; i < 6; ++i) {
    const std::string name = "log" + std::to_string(i);
    before.push_back(testing::farm_result(name, 0.02, 0.02));
    after.push_back(testing::farm_result(name, 0.01, 0.01));
  }
  after[1].icp.reset();  // nothing was mapped
  before[2].fastslam.reset();
  FarmComparison comparison = compare_farms(before, after);
  EXPECT_THAT(comparison.paths[0].only_before, ElementsAre("log1"));
  EXPECT_THAT(comparison.paths[1].only_after, ElementsAre("log2"));
  EXPECT_THAT(comparison_text(comparison), HasSubstr("icp: an error before alone: log1\n"));
  EXPECT_THAT(comparison_text(comparison), HasSubstr("fastslam: an error now alone: log2\n"));
  for (FarmResult& r : after) r.icp.reset();
  comparison = compare_farms(before, after);
  EXPECT_THAT(comparison_text(comparison), HasSubstr("icp: an error before alone: log0, log1, log2"));
}

// A mapper that begins a new map halfway errs by less than one that maps all of the way.
TEST_F(Farm, AMapBegunAgainIsSaidAndIsInNoRatio) {
  std::vector<FarmResult> before, after;
  for (int i = 0; i < 8; ++i) {
    const std::string name = "log" + std::to_string(i);
    before.push_back(testing::farm_result(name, 0.02, 0.02));
    after.push_back(testing::farm_result(name, i < 4 ? 0.001 : 0.02, 0.02));
    after.back().icp_restarts = i < 4 ? 1 : 0;
  }
  before[6].fastslam_restarts = 2;
  const FarmComparison comparison = compare_farms(before, after);
  EXPECT_NEAR(comparison.paths[0].ratio, 1, 1e-9);
  EXPECT_THAT(comparison.paths[0].restarted, ElementsAre("log0", "log1", "log2", "log3"));
  EXPECT_THAT(comparison_text(comparison),
              HasSubstr("fastslam: a new map was begun, so in no ratio: log6\n"));
  const std::string said = "log1: icp began a new map 1 time: its error is of the newest alone";
  EXPECT_THAT(farm_table(after), HasSubstr(said));
  EXPECT_THAT(farm_page("farm", after, std::nullopt), HasSubstr(said));
  json of_a_run = testing::farm_summary(0.01, 0.02);
  of_a_run["paths"]["fastslam"]["restarts"] = 2;
  fs::create_directories(scratch_.path() / "run");
  scratch_.write("run/summary.json", of_a_run.dump());
  EXPECT_EQ(read_result(scratch_.path() / "run", {}).fastslam_restarts, 2);
  EXPECT_EQ(read_result(scratch_.path() / "run", {}).icp_restarts, 0);
}

TEST_F(Farm, FewLogsShowNoDifference) {
  std::vector<FarmResult> before, after;
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(compare_farms(before, after).paths[0].verdict(), "no difference shown") << i;
    before.push_back(testing::farm_result("log" + std::to_string(i), 0.02, 0.02));
    after.push_back(testing::farm_result("log" + std::to_string(i), 0.019 - 0.001 * i, 0.02));
  }
  EXPECT_EQ(compare_farms(before, after).paths[0].verdict(), "better");
}

/// How often a difference is told of six logs whose logarithms of ratios are drawn so.
double share_told(const std::function<double(Random&)>& drawn) {
  constexpr int farms = 4000;
  Random random(7);
  int told = 0;
  for (int farm = 0; farm < farms; ++farm) {
    std::vector<FarmResult> before, after;
    for (int i = 0; i < 6; ++i) {
      before.push_back(testing::farm_result("log" + std::to_string(i), 0.02, 0.02));
      after.push_back(testing::farm_result("log" + std::to_string(i), 0.02 * std::exp(drawn(random)), 0.02));
    }
    told += compare_farms(before, after).paths[0].verdict() != "no difference shown" ? 1 : 0;
  }
  return static_cast<double>(told) / farms;
}

// 5 % are promised; of 4000 farms the share scatters by 0.34 %.
TEST_F(Farm, WhereNothingChangedADifferenceIsToldOneTimeInTwenty) {
  const double normal = share_told([](Random& random) { return random.normal(0, 0.2); });
  EXPECT_LT(normal, 0.06);
  EXPECT_GT(normal, 0.04);
  EXPECT_LT(share_told([](Random& random) {  // many alike, some far off
              return random.normal(0, 0.05) / std::max(0.05, random.uniform());
            }),
            0.06);
  EXPECT_GT(share_told([](Random& random) { return random.normal(0.2, 0.1); }), 0.9);
}

TEST_F(Farm, AComparisonSaysWhatChangedAndWhetherThatIsChance) {
  std::vector<FarmResult> before, after;
  for (int i = 0; i < 12; ++i) {
    const double scale = 0.01 * (1 + i);
    before.push_back(testing::farm_result("log" + std::to_string(i), scale, scale));
    // icp: each a tenth better; fastslam: half of them a fifth better, half as much worse.
    after.push_back(
        testing::farm_result("log" + std::to_string(i), 0.9 * scale, (i % 2 == 0 ? 1.25 : 0.8) * scale));
  }
  before.push_back(testing::farm_result("gone", 1, 1));
  after.push_back(testing::farm_result("new", 1, 1));
  after[3].failures = {"too far off"};
  const FarmComparison comparison = compare_farms(before, after);
  EXPECT_NEAR(comparison.paths[0].ratio, 0.9, 1e-9);
  EXPECT_EQ(comparison.paths[0].verdict(), "better");
  EXPECT_NEAR(comparison.paths[1].ratio, 1, 1e-9);
  EXPECT_EQ(comparison.paths[1].verdict(), "no difference shown");
  EXPECT_NEAR(comparison.paths[1].logs.front().ratio(), 1.25, 1e-9);
  EXPECT_THAT(comparison.broken, ElementsAre("log3"));
  EXPECT_THAT(comparison.missing, ElementsAre("gone"));
  EXPECT_THAT(comparison.added, ElementsAre("new"));
  EXPECT_EQ(compare_farms(after, before).paths[0].verdict(), "worse");
}

}  // namespace
}  // namespace lcmslam

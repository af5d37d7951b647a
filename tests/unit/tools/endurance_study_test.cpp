#include "tools/study/endurance_study.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include <lcmslam/runtime/options.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

std::vector<LapFigures> flat_laps() {
  LapFigures lap;
  lap.frames = 180;
  lap.seconds = 60;
  lap.surf = 10;
  lap.all = 100;
  lap.traffic = 200;
  lap.resident = 500;
  lap.icp_memory = 80;
  lap.landmarks = 8000;
  return std::vector<LapFigures>(12, lap);
}

std::vector<std::string> not_met(const std::vector<LapFigures>& laps, double stop_seconds = 1) {
  std::vector<std::string> names;
  for (const EnduranceVerdict& v : judge_endurance(laps, stop_seconds))
    if (!v.met()) names.push_back(v.what);
  return names;
}

TEST(LapFigures, FlatLapsMeetTheBar) {
  EXPECT_THAT(not_met(flat_laps()), ::testing::IsEmpty());
  std::vector<LapFigures> laps = flat_laps();
  laps[0] = laps[1] = {};  // what the first laps cost does not count
  laps[1].landmarks = 7500;
  for (std::size_t i = 7; i < laps.size(); ++i) laps[i].all = 104;
  laps.back().traffic = 10;  // less is no growth
  EXPECT_THAT(not_met(laps), ::testing::IsEmpty());
}

TEST(LapFigures, EachGrowthIsFound) {
  const auto grown = [](double LapFigures::*figure, double factor) {
    std::vector<LapFigures> laps = flat_laps();
    for (std::size_t i = 7; i < laps.size(); ++i) laps[i].*figure *= factor;
    return not_met(laps);
  };
  EXPECT_THAT(grown(&LapFigures::all, 1.06), ::testing::ElementsAre(HasSubstr("CPU")));
  EXPECT_THAT(grown(&LapFigures::traffic, 1.06), ::testing::ElementsAre(HasSubstr("traffic")));
  EXPECT_THAT(grown(&LapFigures::resident, 1.06), ::testing::ElementsAre(HasSubstr("resident")));
  EXPECT_THAT(grown(&LapFigures::icp_memory, 1.06), ::testing::ElementsAre(HasSubstr("icp counts")));
  EXPECT_THAT(grown(&LapFigures::landmarks, 1.16), ::testing::ElementsAre(HasSubstr("landmarks")));
  EXPECT_THAT(grown(&LapFigures::landmarks, 0.84), ::testing::ElementsAre(HasSubstr("landmarks")));
  EXPECT_THAT(not_met(flat_laps(), 5.1), ::testing::ElementsAre(HasSubstr("stop")));
}

TEST(LapFigures, AMachineThatIsSlowForAWhileIsNoGrowth) {
  std::vector<LapFigures> laps = flat_laps();
  laps.back().all = 120;
  for (std::size_t i = 8; i < laps.size(); ++i) {
    laps[i].all *= 1.3;
    laps[i].surf *= 1.3;
  }
  EXPECT_THAT(not_met(laps), ::testing::IsEmpty());
}

TEST(LapFigures, TheLastLapsAreHeldAgainstTheThirdAndTheSecond) {
  std::vector<LapFigures> laps = flat_laps();
  for (std::size_t i = 2; i < 7; ++i) laps[i].all = 80;
  EXPECT_EQ(not_met(laps).size(), 1U);
  laps = flat_laps();
  laps[1].landmarks = 5000;
  EXPECT_EQ(not_met(laps).size(), 1U);
}

// The same laps on both sides would always be met.
TEST(LapFigures, FewLapsAreNotJudged) {
  auto laps = flat_laps();
  laps.pop_back();
  const auto verdicts = judge_endurance(laps, 1);
  EXPECT_FALSE(verdicts[0].judged);
  EXPECT_FALSE(verdicts[0].met());
  for (std::size_t i = 1; i < verdicts.size(); ++i) EXPECT_TRUE(verdicts[i].met()) << verdicts[i].what;
  EXPECT_THAT(verdict_lines(verdicts), HasSubstr("third to seventh: -, not judged, laps are too few"));
  laps.resize(3);
  EXPECT_THAT(not_met(laps), ::testing::ElementsAre(HasSubstr("CPU"), HasSubstr("traffic"),
                                                    HasSubstr("resident"), HasSubstr("icp counts")));
}

TEST(LapFigures, AreTold) {
  const auto laps = flat_laps();
  const auto verdicts = judge_endurance(laps, 7);
  EXPECT_THAT(verdict_lines(verdicts), HasSubstr("seconds to stop: 7.000, NOT MET (at most 5)"));
  EXPECT_THAT(verdict_lines(verdicts), HasSubstr("1.000, met (from 0.85 to 1.15)"));
  const std::string table = endurance_table(laps);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 12 + 2);
  const nlohmann::json json = endurance_json(laps, verdicts);
  EXPECT_EQ(json.at("laps").size(), 12U);
  EXPECT_EQ(json.at("laps")[5].at("all_ms"), 100);
  EXPECT_EQ(json.at("verdicts").back().at("met"), false);
}

TEST(EnduranceStudy, CountsEachLap) {
  const testing::ScratchFolder scratch;
  EnduranceSettings settings;
  settings.simulation.scene = source_folder() / "config/scenes/kitchen.yaml";
  settings.simulation.frame_rate = 1;
  settings.simulation.seconds = 6;
  settings.simulation.laps = 2;  // here of three frames each: the robot rests, then drives off
  settings.config = load_config(source_folder() / "config/replay.yaml", {"fastslam.particles=20"});
  settings.folder = scratch.path() / "maps";
  int told = 0;
  settings.after_lap = [&](const LapFigures&) { ++told; };
  const EnduranceResult result = study_endurance(settings);
  ASSERT_EQ(result.laps.size(), 2U);
  EXPECT_EQ(told, 2);
  for (const LapFigures& lap : result.laps) {
    EXPECT_EQ(lap.frames, 3);
    EXPECT_NEAR(lap.seconds, 3, 0.05);
    for (const double figure : {lap.surf, lap.odometry, lap.fastslam, lap.icp, lap.map_server, lap.traffic,
                                lap.fastslam_traffic, lap.icp_traffic, lap.graph_traffic, lap.resident,
                                lap.icp_memory, lap.landmarks, lap.keyframes, lap.graph_nodes})
      EXPECT_GT(figure, 0);
    EXPECT_NEAR(lap.surf + lap.odometry + lap.fastslam + lap.icp + lap.map_server + lap.beside, lap.all,
                1e-6);
    EXPECT_GT(lap.all, lap.surf + lap.icp);
    EXPECT_GT(lap.traffic, lap.fastslam_traffic + lap.icp_traffic);
    EXPECT_GT(lap.icp_traffic, lap.graph_traffic);
    EXPECT_LT(lap.fastslam_error, 0.05);
    EXPECT_LT(lap.icp_error, 0.05);
  }
  EXPECT_GT(result.laps[1].icp_error, 0);
  EXPECT_TRUE(std::filesystem::exists(settings.folder / "icp_map.ply"));
  EXPECT_TRUE(std::filesystem::exists(settings.folder / "fastslam_map.ply"));
}

}  // namespace
}  // namespace lcmslam

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"
#include "tools/farm/batch_farm.hpp"
#include "tools/farm/farm.hpp"
#include "tools/farm/farm_report.hpp"
#include "tools/farm/run_key.hpp"
#include "tools/farm/slurm.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// As batch writes it.
json summary(double icp, double fastslam, const std::string& key = "k") {
  json s = {{"key", key}, {"events", json::array()}, {"frames", 40}, {"timing", {{"wall_seconds", 2.5}}}};
  s["paths"]["icp"] = {{"ate", {{"translation_rmse_m", icp}}}, {"tracked_fraction", 0.98}, {"lost", 3}};
  s["paths"]["fastslam"] = {{"ate", {{"translation_rmse_m", fastslam}}}};
  s["paths"]["odometry"] = {{"ate", {{"translation_rmse_m", 0.2}}}};
  return s;
}

FarmResult result(const std::string& name, double icp, double fastslam) {
  FarmResult r;
  r.name = name;
  r.has_summary = true;
  r.icp = icp;
  r.fastslam = fastslam;
  return r;
}

class Farm : public ::testing::Test {
 protected:
  fs::path log(const std::string& name, const std::string& text = "log") {
    const fs::path file = scratch_.path() / "logs" / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
    return file;
  }
  /// Jobs whose program is a shell that notes that it ran, and writes a summary or does what it is told.
  FarmOptions farm(const std::vector<fs::path>& logs) {
    FarmOptions options;
    options.folder = scratch_.path() / "farm";
    options.jobs = farm_jobs(logs);
    options.at_a_time = 2;
    options.key = [](const FarmJob& job) { return "key of " + job.name; };
    options.command = [this](const FarmJob& job, const fs::path& folder, const std::string& key) {
      const std::string ran = "echo " + job.name + " >> '" + (scratch_.path() / "ran").string() + "'; ";
      const auto own = commands_.find(job.name);
      const std::string then = own != commands_.end() ? own->second
                                                      : "echo '" + summary(0.01, 0.02, key).dump() + "' > '" +
                                                            (folder / "summary.json").string() + "'";
      return std::vector<std::string>{"/bin/sh", "-c", ran + then};
    };
    return options;
  }
  std::string ran() { return scratch_.read("ran"); }

  testing::ScratchFolder scratch_;
  std::map<std::string, std::string> commands_;
  std::ostringstream out_;
};

TEST_F(Farm, LogsAreNamedAfterTheirFilesAndTheirFoldersWhereThoseAreTheSame) {
  const auto jobs = farm_jobs({log("a/run.lcmlog"), log("b/run.lcmlog"), log("b/other.lcmlog")});
  std::vector<std::string> names;
  for (const FarmJob& job : jobs) names.push_back(job.name);
  EXPECT_THAT(names, ElementsAre("a__run", "b__run", "other"));
  EXPECT_THROW(farm_jobs({log("a/run.lcmlog"), scratch_.path() / "logs/b/../a/run.lcmlog"}),
               std::runtime_error);
  EXPECT_THROW(farm_jobs({scratch_.path() / "none.lcmlog"}), std::runtime_error);
}

TEST_F(Farm, AListNamesLogsRelativeToItself) {
  const fs::path list = scratch_.write("logs.txt", "# night shift\nlogs/a.lcmlog\n\n/else/b.lcmlog  \n");
  EXPECT_THAT(read_log_list(list),
              ElementsAre(scratch_.path() / "logs/a.lcmlog", fs::path("/else/b.lcmlog")));
  EXPECT_THROW(read_log_list(scratch_.write("empty.txt", "# none\n")), std::runtime_error);
}

TEST_F(Farm, SharesTogetherAreTheWholeAndNothingTwice) {
  std::vector<FarmJob> jobs(11);
  for (std::size_t i = 0; i < jobs.size(); ++i) jobs[i].name = std::to_string(i);
  std::multiset<std::string> names;
  for (const char* share : {"0/4", "1/4", "2/4", "3/4"})
    for (const FarmJob& job : share_of(jobs, parse_share(share))) names.insert(job.name);
  EXPECT_EQ(names.size(), 11U);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 11U);
  for (const char* wrong : {"4/4", "-1/4", "1", "1/", "1/0", "a/b", "1/4x", "", "/4"})
    EXPECT_THROW(parse_share(wrong), std::runtime_error) << wrong;
}

TEST_F(Farm, WhatIsDoneIsNotRunAgainUnlessItsKeyHasChanged) {
  FarmOptions options = farm({log("a.lcmlog"), log("b.lcmlog"), log("c.lcmlog")});
  EXPECT_EQ(exit_code_of(run_farm(options, out_)), 0);
  EXPECT_EQ(ran().size(), 6U) << ran();
  fs::remove(options.folder / "b" / "summary.json");  // as if it had been killed in the middle
  options.key = [](const FarmJob& job) { return job.name == "c" ? "other" : "key of " + job.name; };
  fs::remove(scratch_.path() / "ran");
  EXPECT_EQ(exit_code_of(run_farm(options, out_)), 0);
  EXPECT_THAT(ran(), AllOf(HasSubstr("b\n"), HasSubstr("c\n"), Not(HasSubstr("a\n"))));
  EXPECT_THAT(out_.str(), HasSubstr("3 logs: 1 done before, 2 to run, 2 at a time"));
}

TEST_F(Farm, ARunThatEndsWithoutASummaryIsNoResultAndItsLastWordsAreToldAndTheOldResultIsGone) {
  FarmOptions options = farm({log("a.lcmlog"), log("b.lcmlog")});
  fs::create_directories(options.folder / "a");
  std::ofstream(options.folder / "a/summary.json") << summary(0.01, 0.01, "an older key").dump();
  commands_["a"] = "echo 'reads the log'; echo 'lcmslam batch: the log is bad' >&2; exit 2";
  const auto results = run_farm(options, out_);
  EXPECT_EQ(exit_code_of(results), 2);
  EXPECT_FALSE(results[0].has_summary);
  EXPECT_THAT(results[0].failures, ElementsAre("lcmslam batch: the log is bad"));
  EXPECT_TRUE(results[1].passed());
  EXPECT_THAT(out_.str(), HasSubstr("a: lcmslam batch: the log is bad"));
}

TEST_F(Farm, ARunThatIsNotOfAFarmKeepsItsResults) {
  FarmOptions options = farm({log("a.lcmlog"), log("b.lcmlog")});
  fs::create_directories(options.folder / "b");
  json by_hand = summary(0.01, 0.01);
  by_hand.erase("key");
  scratch_.write("farm/b/summary.json", by_hand.dump());
  EXPECT_THROW(run_farm(options, out_), std::runtime_error);
  EXPECT_EQ(ran(), "") << "nothing runs before that is settled";
  EXPECT_EQ(scratch_.read("farm/b/summary.json"), by_hand.dump());
  options.force = true;
  EXPECT_EQ(exit_code_of(run_farm(options, out_)), 0);
  // A live run that was killed has no summary yet, a farm's own run then has what it said.
  options.force = false;
  fs::remove(options.folder / "a/summary.json");
  scratch_.write("farm/a/icp_map.ply", "a map");
  scratch_.write("farm/a/batch.txt", "");
  EXPECT_EQ(exit_code_of(run_farm(options, out_)), 0);
  fs::remove(options.folder / "a/summary.json");
  fs::remove(options.folder / "a/batch.txt");
  EXPECT_THROW(run_farm(options, out_), std::runtime_error);
}

TEST_F(Farm, BarsAreThoseOfTheLastPatternThatFits) {
  const Expectations bars(scratch_.write("expect.yaml",
                                         "icp: {ate: 0.02, tracked: 0.95, lost: 5}\n"
                                         "logs:\n  \"office_*\": {icp: {ate: 0.001}, fastslam: {rpe: 1}}\n"));
  EXPECT_THAT(bars.failures("kitchen_1", summary(0.01, 0.5)), IsEmpty());
  EXPECT_THAT(bars.failures("kitchen_1", summary(0.03, 0.5)),
              ElementsAre("icp.ate is 0.03, expected at most 0.02"));
  EXPECT_THAT(bars.failures("office_1", summary(0.01, 0.5)),
              ElementsAre("icp.ate is 0.01, expected at most 0.001", HasSubstr("fastslam.rpe is not known")));
  json late = summary(0.01, 0.01);
  late["paths"]["icp"]["tracked_fraction"] = 0.9;
  late["paths"]["icp"]["lost"] = 6;
  late["events"] = {"icp mapped nothing"};
  json apart = summary(0.01, 0.01);
  apart["paths"]["icp"].erase("ate");
  apart["paths"]["icp"]["truth_problem"] = "the truth is 3 s apart";
  EXPECT_THAT(bars.failures("kitchen_1", apart), ElementsAre("icp.ate is not known: the truth is 3 s apart"));
  EXPECT_THAT(bars.failures("kitchen_1", late),
              ElementsAre("icp mapped nothing", "icp.tracked is 0.9, expected at least 0.95",
                          "icp.lost is 6, expected at most 5"));
}

TEST_F(Farm, AMistakeAmongTheBarsIsNamedWithItsLine) {
  try {
    Expectations(scratch_.write("expect.yaml", "icp:\n  aet: 0.02\n"));
    FAIL() << "it was taken";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("expect.yaml"), HasSubstr("2"), HasSubstr("ate")));
  }
}

TEST_F(Farm, TheKeyIsOfLogConfigurationAndOptions) {
  const fs::path config = scratch_.write("c.yaml", "include: base.yaml\n");
  scratch_.write("base.yaml", "icp: {voxel_size: 0.04}\n");
  const RunInputs inputs{log("a.lcmlog"), config, {"icp.pose=auto"}, {}, 0, 0};
  const std::string key = run_key(inputs);
  EXPECT_EQ(run_key(inputs), key);
  RunInputs other = inputs;
  other.overrides = {"icp.pose=6dof"};
  EXPECT_NE(run_key(other), key);
  other = inputs;
  other.to = 3;
  EXPECT_NE(run_key(other), key);
  other = inputs;
  other.kitti = true;
  EXPECT_NE(run_key(other), key);
  scratch_.write("base.yaml", "icp: {voxel_size: 0.05}\n");
  EXPECT_NE(run_key(inputs), key) << "what is included counts";
  scratch_.write("base.yaml", "icp: {voxel_size: 0.04}\n");
  EXPECT_EQ(run_key(inputs), key);
  log("a.lcmlog", "another log");
  EXPECT_NE(run_key(inputs), key);
}

TEST_F(Farm, TheWorstComeFirst) {
  FarmResult without, failed = result("failed", 0.001, 0.001);
  without.name = "without";
  without.failures = {"x"};
  failed.failures = {"y"};
  std::vector<FarmResult> results = {result("good", 0.01, 0.01), result("worse", 0.01, 0.09), failed,
                                     without};
  put_worst_first(results);
  std::vector<std::string> names;
  for (const FarmResult& r : results) names.push_back(r.name);
  EXPECT_THAT(names, ElementsAre("without", "failed", "worse", "good"));
}

TEST_F(Farm, WhereNothingWasMappedIsWorseThanAnyError) {
  std::vector<FarmResult> results = {result("good", 0.01, 0.01), result("bad", 0.3, 0.01),
                                     result("unmapped", 0, 0.01), result("without truth", 0, 0)};
  results[2].icp.reset();
  results[3].icp.reset(), results[3].fastslam.reset();
  for (std::size_t i = 0; i < 3; ++i) results[i].odometry = 0.2;
  put_worst_first(results);
  std::vector<std::string> names;
  for (const FarmResult& r : results) names.push_back(r.name);
  EXPECT_THAT(names, ElementsAre("unmapped", "bad", "good", "without truth"));
}

TEST_F(Farm, AComparisonNamesTheLogsThatAreInNoRatio) {
  std::vector<FarmResult> before, after;
  for (int i = 0; i < 6; ++i) {
    const std::string name = "log" + std::to_string(i);
    before.push_back(result(name, 0.02, 0.02));
    after.push_back(result(name, 0.01, 0.01));
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
    before.push_back(result(name, 0.02, 0.02));
    after.push_back(result(name, i < 4 ? 0.001 : 0.02, 0.02));
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
  json of_a_run = summary(0.01, 0.02);
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
    before.push_back(result("log" + std::to_string(i), 0.02, 0.02));
    after.push_back(result("log" + std::to_string(i), 0.019 - 0.001 * i, 0.02));
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
      before.push_back(result("log" + std::to_string(i), 0.02, 0.02));
      after.push_back(result("log" + std::to_string(i), 0.02 * std::exp(drawn(random)), 0.02));
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
    before.push_back(result("log" + std::to_string(i), scale, scale));
    // icp: each a tenth better; fastslam: half of them a fifth better, half as much worse.
    after.push_back(result("log" + std::to_string(i), 0.9 * scale, (i % 2 == 0 ? 1.25 : 0.8) * scale));
  }
  before.push_back(result("gone", 1, 1));
  after.push_back(result("new", 1, 1));
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

TEST_F(Farm, JUnitAndThePageSurviveWhatLogsSay) {
  FarmResult r = result("a<b>\"&", 0.01, 0.01);
  r.failures = {"expected <0.1 & \"more\"\x01"};
  const std::string xml = junit_xml("farm", {r, result("good", 0.01, 0.01)});
  EXPECT_THAT(
      xml,
      AllOf(HasSubstr("tests=\"2\" failures=\"1\" errors=\"0\""), HasSubstr("name=\"a&lt;b&gt;&quot;&amp;\""),
            HasSubstr("expected &lt;0.1 &amp; &quot;more&quot;\n</failure>"), Not(HasSubstr("\x01"))));
  EXPECT_THAT(farm_page("t", {r}, std::nullopt), Not(HasSubstr("a<b>")));
}

TEST_F(Farm, SlurmGetsAnArrayOfShares) {
  SlurmArray array;
  array.folder = "/data/farm";
  array.command = {"/opt/lcmslam-tools", "batch", "it's.yaml"};
  array.tasks = 40;
  EXPECT_THAT(
      slurm_script(array),
      AllOf(HasSubstr("#SBATCH --array=0-39\n"), HasSubstr("#SBATCH --output=/data/farm/slurm-%a.txt\n"),
            HasSubstr(
                "exec '/opt/lcmslam-tools' 'batch' 'it'\\''s.yaml' --share \"$SLURM_ARRAY_TASK_ID/40\"")));
}

TEST_F(Farm, WhatCannotBeDoneIsRefusedBeforeAnyWork) {
  FarmArguments arguments;
  arguments.config = "c.yaml";
  EXPECT_THAT(farm_problem(arguments).value_or(""), HasSubstr("log is required"));
  arguments.logs = {log("a").string(), log("b").string()};
  EXPECT_THAT(farm_problem(arguments).value_or(""), HasSubstr("--out"));
  arguments.out = "farm";
  EXPECT_FALSE(farm_problem(arguments));
  arguments.slurm = true;
  arguments.share = "0/2";
  EXPECT_THAT(farm_problem(arguments).value_or(""), HasSubstr("--share"));
}

TEST_F(Farm, CollectWritesPageAndJUnitAndGivesTheVerdict) {
  FarmOptions options = farm({log("a.lcmlog"), log("b.lcmlog")});
  run_farm(options, out_);
  const std::string folder = options.folder.string();
  const testing::CommandRun passed = testing::run_command({"collect", collect_command}, {folder});
  EXPECT_EQ(passed.exit_code, 0) << passed.errors;
  EXPECT_THAT(passed.out,
              HasSubstr("2 logs: 2 passed, 0 failed, 0 without a result; median ATE: icp 0.0100 m"));
  EXPECT_TRUE(fs::exists(options.folder / "report.html"));
  scratch_.write("farm/b/summary.json", summary(0.03, 0.02).dump());
  EXPECT_THAT(testing::run_command({"collect", collect_command}, {folder}).out,
              HasSubstr("median ATE: icp 0.0200 m"));
  scratch_.write("farm/expect.yaml", "icp: {ate: 0.001}\n");
  const testing::CommandRun failed = testing::run_command({"collect", collect_command}, {folder});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(scratch_.read("farm/junit.xml"), HasSubstr("failures=\"2\""));
}

}  // namespace
}  // namespace lcmslam

#include <gmock/gmock.h>

#include <lcmslam/configuration/config.hpp>
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/farm_fixture.hpp"
#include "tools/commands.hpp"
#include "tools/farm/batch_farm.hpp"
#include "tools/farm/farm_report.hpp"
#include "tools/farm/run_key.hpp"
#include "tools/farm/slurm.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using testing::Farm;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

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
  std::ofstream(options.folder / "a/summary.json")
      << testing::farm_summary(0.01, 0.01, "an older key").dump();
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
  json by_hand = testing::farm_summary(0.01, 0.01);
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
  EXPECT_THAT(bars.failures("kitchen_1", testing::farm_summary(0.01, 0.5)), IsEmpty());
  EXPECT_THAT(bars.failures("kitchen_1", testing::farm_summary(0.03, 0.5)),
              ElementsAre("icp.ate is 0.03, expected at most 0.02"));
  EXPECT_THAT(bars.failures("office_1", testing::farm_summary(0.01, 0.5)),
              ElementsAre("icp.ate is 0.01, expected at most 0.001", HasSubstr("fastslam.rpe is not known")));
  json late = testing::farm_summary(0.01, 0.01);
  late["paths"]["icp"]["tracked_fraction"] = 0.9;
  late["paths"]["icp"]["lost"] = 6;
  late["events"] = {"icp mapped nothing"};
  json apart = testing::farm_summary(0.01, 0.01);
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
  FarmResult without, failed = testing::farm_result("failed", 0.001, 0.001);
  without.name = "without";
  without.failures = {"x"};
  failed.failures = {"y"};
  std::vector<FarmResult> results = {testing::farm_result("good", 0.01, 0.01),
                                     testing::farm_result("worse", 0.01, 0.09), failed, without};
  put_worst_first(results);
  std::vector<std::string> names;
  for (const FarmResult& r : results) names.push_back(r.name);
  EXPECT_THAT(names, ElementsAre("without", "failed", "worse", "good"));
}

TEST_F(Farm, WhereNothingWasMappedIsWorseThanAnyError) {
  std::vector<FarmResult> results = {
      testing::farm_result("good", 0.01, 0.01), testing::farm_result("bad", 0.3, 0.01),
      testing::farm_result("unmapped", 0, 0.01), testing::farm_result("without truth", 0, 0)};
  results[2].icp.reset();
  results[3].icp.reset(), results[3].fastslam.reset();
  for (std::size_t i = 0; i < 3; ++i) results[i].odometry = 0.2;
  put_worst_first(results);
  std::vector<std::string> names;
  for (const FarmResult& r : results) names.push_back(r.name);
  EXPECT_THAT(names, ElementsAre("unmapped", "bad", "good", "without truth"));
}

TEST_F(Farm, JUnitAndThePageSurviveWhatLogsSay) {
  FarmResult r = testing::farm_result("a<b>\"&", 0.01, 0.01);
  r.failures = {"expected <0.1 & \"more\"\x01"};
  const std::string xml = junit_xml("farm", {r, testing::farm_result("good", 0.01, 0.01)});
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
  scratch_.write("farm/b/summary.json", testing::farm_summary(0.03, 0.02).dump());
  EXPECT_THAT(testing::run_command({"collect", collect_command}, {folder}).out,
              HasSubstr("median ATE: icp 0.0200 m"));
  scratch_.write("farm/expect.yaml", "icp: {ate: 0.001}\n");
  const testing::CommandRun failed = testing::run_command({"collect", collect_command}, {folder});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(scratch_.read("farm/junit.xml"), HasSubstr("failures=\"2\""));
}

}  // namespace
}  // namespace lcmslam

// The study's report: what is kept of experiments, and what may differ between two runs.

#include <gmock/gmock.h>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>

#include <lcmslam/runtime/stop_signal.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"
#include "tools/study/demo_study.hpp"
#include "tools/study/option_use.hpp"
#include "tools/study/own_studies.hpp"
#include "tools/study/report/study_json.hpp"
#include "tools/study/report/study_page.hpp"
#include "tools/study/report/study_run.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

Experiment small_experiment() {
  return {
      "small", "A small one", "figure 2.1", [](const StudyContext& context) {
        ExperimentResult result;
        result.finding = "Ends with </script> at 1 cm.";
        result.agreement = Agreement::agrees_in_part;
        result.seeds = context.seeds;
        result.charts = {{"Errors",
                          {"seed", ""},
                          {"error", "cm"},
                          {{"ours", ChartSeries::Mark::line, {1, 2}, {0.123456789, std::nan("")}, {}, {}}},
                          false}};
        result.heat_maps = {
            {"Map", {"x", "m"}, {"y", "m"}, {"error", "cm"}, {1, 2}, {3}, {{4, std::nan("")}}}};
        result.tables = {{"Table", {"name", "cm"}, {{"ours", std::nan("")}}}};
        result.settings = {{"sigma_m", std::numeric_limits<double>::infinity()}};
        const auto file = context.work / "map.png";
        std::ofstream(file) << "pixels";
        result.pictures = {{"Map", "A kitchen", file}};
        return result;
      }};
}

Experiment failing_experiment() {
  return {"failing", "One that fails", "",
          [](const StudyContext&) -> ExperimentResult { throw std::runtime_error("no such scene"); }};
}

class StudyRun : public ::testing::Test {
 protected:
  StudyRun() {
    std::filesystem::create_directories(settings_.page);
    scratch_.write("page/index.html", R"(<link rel="icon" href="icon.svg"><link href="report.css">
<noscript>See report.json.</noscript><script src="report.js"></script>)");
    scratch_.write("page/report.css", "p {}");
    scratch_.write("page/report.js", "draw();");
  }
  json report() const { return json::parse(scratch_.read("out/report.json")); }

  testing::ScratchFolder scratch_;
  StudyRunSettings settings_ = [this] {
    StudyRunSettings s;
    s.out = scratch_.path() / "out";
    s.page = scratch_.path() / "page";
    s.quick = true;
    s.seeds = {3, 4};
    return s;
  }();
};

TEST_F(StudyRun, WhatWasNotMeasuredIsNullEverywhere) {
  EXPECT_TRUE(run_study({small_experiment()}, settings_));
  const json told = report().at("experiments").at(0);
  EXPECT_EQ(told.at("charts")[0].at("series")[0].at("y"), json({0.123457, nullptr}));
  EXPECT_EQ(told.at("heat_maps")[0].at("values"), json({{4, nullptr}}));
  EXPECT_TRUE(told.at("tables")[0].at("rows")[0][1].is_null());
  EXPECT_TRUE(told.at("settings").at("sigma_m").is_null());
  EXPECT_EQ(told.at("agreement"), "agrees in part");
  EXPECT_EQ(told.at("seeds"), json({3, 4}));
}

TEST_F(StudyRun, AnExperimentThatFailsIsShownAndTheRestIsRun) {
  std::vector<std::string> ended;
  settings_.ended = [&](const std::string& name, const std::string& error) { ended.push_back(name + error); };
  EXPECT_FALSE(run_study({failing_experiment(), small_experiment()}, settings_));
  const json all = report().at("experiments");
  EXPECT_EQ(all[0].at("status"), "failed");
  EXPECT_EQ(all[0].at("error"), "no such scene");
  EXPECT_EQ(all[0].at("title"), "One that fails");
  EXPECT_EQ(all[1].at("status"), "done");
  EXPECT_EQ(ended, (std::vector<std::string>{"failingno such scene", "small"}));
  EXPECT_THAT(scratch_.read("out/index.html"), HasSubstr("no such scene"));
}

TEST_F(StudyRun, ThePageHoldsAllThatItNeeds) {
  run_study({small_experiment()}, settings_);
  EXPECT_EQ(scratch_.read("out/pictures/small/map.png"), "pixels");
  EXPECT_FALSE(std::filesystem::exists(settings_.out / "work")) << "what experiments leave";
  const std::string page = scratch_.read("out/index.html");
  EXPECT_THAT(page, HasSubstr("data:image/png;base64,cGl4ZWxz"));
  EXPECT_THAT(page, HasSubstr("<style>p {}</style>"));
  EXPECT_THAT(page, HasSubstr("<script>draw();</script>"));
  EXPECT_THAT(page, Not(HasSubstr("src=")));
  const std::string opening = "id=\"lcmslam-report\">";
  const std::size_t begin = page.find(opening) + opening.size();
  const json inside = json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  EXPECT_EQ(inside.at("experiments")[0].at("finding"), "Ends with </script> at 1 cm.");
}

TEST_F(StudyRun, APictureThatIsNotThereFailsItsExperiment) {
  Experiment experiment = small_experiment();
  experiment.run = [run = experiment.run](const StudyContext& context) {
    ExperimentResult result = run(context);
    std::filesystem::remove(result.pictures[0].file);
    return result;
  };
  EXPECT_FALSE(run_study({experiment}, settings_));
  EXPECT_THAT(report().at("experiments")[0].at("error").get<std::string>(), HasSubstr("map.png"));
}

TEST_F(StudyRun, SeriesWhoseLengthsDifferAreRefused) {
  ExperimentResult result;
  result.charts = {{"", {}, {}, {{"ours", ChartSeries::Mark::line, {1, 2}, {1}, {}, {}}}, false}};
  EXPECT_THROW(experiment_json(result), std::invalid_argument);
  result.charts = {};
  result.heat_maps = {{"", {}, {}, {}, {1, 2}, {1}, {{1}}}};
  EXPECT_THROW(experiment_json(result), std::invalid_argument);
  result.heat_maps = {};
  result.tables = {{"", {"a", "b"}, {{1}}}};
  EXPECT_THROW(experiment_json(result), std::invalid_argument);
}

// On the drawing of figures 2.1 and 2.2 and on FastSLAM itself.
TEST_F(StudyRun, TheSameSeedsGiveTheSameReportButForTimingAndMemory) {
  std::vector<Experiment> experiments = experiments_named(study_experiments(), "sampled-poses");
  experiments.push_back(experiments_named(study_experiments(), "filter-divergence").front());
  const auto without_times = [&] {
    json report = run_experiments(experiments, settings_);
    for (json& experiment : report["experiments"]) {
      EXPECT_GT(experiment.at("timing").at("seconds").get<double>(), 0);
      EXPECT_EQ(experiment.erase("timing") + experiment.erase("memory"), 2U);
    }
    return report.dump();
  };
  const std::string first = without_times();
  EXPECT_EQ(first, without_times());
  settings_.seeds = {5, 6};
  EXPECT_NE(first, without_times()) << "seeds are used";
}

TEST(Study, HasTheThesissOrder) {
  std::vector<std::size_t> at(3, 0);
  const auto all = study_experiments();
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const auto& [name, place] : {std::pair{"sampled-poses", 0}, {"dense-maps", 1}, {"mappers", 2}})
      if (all[i].name == name) at[static_cast<std::size_t>(place)] = i;
  EXPECT_EQ(at[0], 0U);
  EXPECT_LT(at[0], at[1]);
  EXPECT_LT(at[1], at[2]);
}

/// Studies make their folders in the current one.
class InScratchFolder {
 public:
  InScratchFolder() { std::filesystem::current_path(scratch_.path()); }
  ~InScratchFolder() { std::filesystem::current_path(before_); }
  InScratchFolder(const InScratchFolder&) = delete;
  InScratchFolder& operator=(const InScratchFolder&) = delete;

 private:
  const testing::ScratchFolder scratch_;
  const std::filesystem::path before_ = std::filesystem::current_path();
};

TEST_F(StudyRun, ASeedThatFailsCostsTheOthersNothing) {
  const InScratchFolder here;
  DemoStudySettings settings;
  settings.seeds = {1, 2, 3};
  ::testing::internal::CaptureStdout();
  const int exit_code = study_demo(settings, [](const auto& arguments, const auto&) {
    if (arguments.at(1) == "2") throw std::runtime_error("the camera burnt");
    json summary = {{"frames", 7}};
    for (const char* path : {"odometry", "fastslam", "icp"})
      summary["paths"][path] = {
          {"poses", 5}, {"lost", 0}, {"ate", {{"translation_rmse_m", arguments.at(1) == "1" ? 0.25 : 0.75}}}};
    return summary;
  });
  const std::string out = ::testing::internal::GetCapturedStdout();
  EXPECT_EQ(exit_code, 1);
  EXPECT_THAT(out, HasSubstr("seed 2: the camera burnt"));
  EXPECT_THAT(out, HasSubstr("seed 2 failed, and is in no row"));
  EXPECT_THAT(out.substr(out.find("median")), HasSubstr("0.5000"));
}

// In a process of its own, for a stop cannot be taken back.
TEST_F(StudyRun, AStopEndsItWithTheSeedsThatWereDone) {
  const InScratchFolder here;
  DemoStudySettings settings;
  settings.seeds = {1, 2, 3};
  EXPECT_EXIT(
      {
        std::cout.rdbuf(std::cerr.rdbuf());
        std::_Exit(study_demo(settings, [](const auto& arguments, const auto&) -> json {
          if (arguments.at(1) == "2") {
            request_stop();
            throw std::runtime_error("stopped");
          }
          json summary = {{"frames", 7}};
          for (const char* path : {"odometry", "fastslam", "icp"})
            summary["paths"][path] = {{"poses", 5}, {"lost", 0}};
          return summary;
        }));
      },
      ::testing::ExitedWithCode(130),
      "seed 1: done\n.*\nstopped by a signal: the other seeds are in no row\n\nruns: ");
}

// Figures must not be taken for those of settings that nobody looked at.
TEST(Study, OptionsThatAStudyDoesNotUseAreRefused) {
  using Words = std::vector<std::string>;
  const InScratchFolder here;
  const std::string log = (source_folder() / "logs/kitchen.lcmlog").string();
  for (const auto& [words, said] :
       {std::pair<Words, std::string>{{"--only", "sampled-poses", "--set", "fastslam.particles=5"},
                                      "the report does not use --set; it takes --seeds, --data, --out"},
        {{"--quick", "--seconds", "2"}, "the report does not use --seconds"},
        {{"--quick", "--config", (source_folder() / "config/replay.yaml").string()}, "use --config"},
        {{"--only", "sampled-poses", log}, "the report does not use logs"},
        {{"--only", "consistency", "--seeds", "1,2", "--", log}, "--only consistency does not use --seeds"},
        {{"--only", "kills", "--set", "icp.seed=1"}, "--only kills does not use --set"},
        {{"--only", "filter", log, "--out", "x"}, "--only filter does not use --out"},
        {{"--only", "endurance", "--quick"}, "--only endurance does not use --quick"},
        {{"--only", "depth-filter", "--seeds", "1,2"}, "--only depth-filter takes one seed, not 2"}}) {
    const auto run = testing::run_command({"study", study_command}, words);
    ASSERT_EQ(run.exit_code, 2) << said;  // a study that begins may take long
    EXPECT_THAT(run.errors, HasSubstr(said));
  }
  for (const std::string& study : own_studies()) EXPECT_FALSE(option_problem(study, {})) << study;
  EXPECT_FALSE(option_problem("filter", {{"--seeds", "logs", "--scene", "--set"}, 3}));
  EXPECT_FALSE(option_problem("demo", {{"--seeds", "--seconds", "--set"}, 3}));
}

TEST(Study, AnUnknownNameListsTheNames) {
  try {
    experiments_named(study_experiments(), "nothing");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("'nothing'; there are sampled-poses, "));
  }
  const auto run = testing::run_command({"study", study_command}, {"--only", "nothing", "--out", "x"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("sampled-poses"));
}

}  // namespace
}  // namespace lcmslam

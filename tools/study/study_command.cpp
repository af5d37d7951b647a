#include <algorithm>
#include <iostream>

#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/commands.hpp"
#include "tools/parse_command.hpp"
#include "tools/study/demo_study.hpp"
#include "tools/study/option_use.hpp"
#include "tools/study/own_studies.hpp"
#include "tools/study/report_command.hpp"

namespace lcmslam {
namespace {

/// Those that say what to study, without those that choose the study.
GivenOptions given_options(const CLI::App& app, std::size_t seeds) {
  GivenOptions given;
  given.seeds = seeds;
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    const auto& names = option->get_lnames();
    const std::string name = names.empty() ? option->get_name(true) : "--" + names.front();
    if (name != "--only") given.names.push_back(name);
  }
  return given;
}

}  // namespace

int study_command(int argc, char** argv) {
  OwnStudyOptions o;
  std::vector<int> seeds;
  std::string only, out;
  double seconds = 0;
  bool quick = false;
  CLI::App app{
      "--out FOLDER: the thesis's experiments on the simulation and on the recordings below --data, and a "
      "report of them (docs/STUDY.md); --only NAME: one of them. Without: runs the demo live once for "
      "each seed and prints the errors of all runs. "
      "--only features: instead, how well features are found again and matched on a recording, ours beside "
      "dlib's SURF, SIFT and ORB. --only pairs: how often two clouds are registered without a start. "
      "--only landmarks: MRCLAM or Victoria Park in batch, once for each seed. --only filter: logs with "
      "images and truth through odometry and fastslam in batch, each with each seed. "
      "--only consistency: logs with truth (SCENE_SEED.lcmlog) in batch; whether both mappers err as much as "
      "their covariances say. "
      "--only depth-filter: mixed pixels removed and good points lost in simulated depth images. "
      "--only resampling: FastSLAM's four schemes on a log. "
      "--only faults: the live graph while stamps jump, processes die, the camera is covered, strangers send "
      "and the disk fills. --only kills: laps of the kitchen, live, while every half minute a process is "
      "killed. "
      "--only endurance: memory, traffic and CPU of many laps of the kitchen in one process; ends with 0 "
      "only "
      "where they stay flat.",
      "lcmslam study"};
  app.add_option("--seeds,--seed", seeds, "of sensors and particles")->delimiter(',');
  app.add_option("--config", o.config, "as for the demo")->check(CLI::ExistingFile);
  app.add_option("--data", o.data,
                 "a recording instead of the simulation (pairs: also a log; report: a folder of them)")
      ->check(CLI::ExistingPath);
  app.add_option("--seconds", seconds, "only the first so many seconds");
  app.add_option("--set", o.overrides, "override: section.key=value");
  std::vector<std::string> names = own_studies();
  const std::vector<std::string> experiments = report_names();
  names.insert(names.end(), experiments.begin(), experiments.end());
  const auto only_option = app.add_option("--only", only, "one study or one of the report's experiments")
                               ->check(CLI::IsMember(names));
  app.add_option("--out", out, "report: its folder");
  app.add_flag("--quick", quick, "report: few seeds and pairs, in less than three minutes");
  app.add_option("logs", o.logs, "filter, consistency: .lcmlog files")
      ->check(CLI::ExistingFile)
      ->needs(only_option);
  app.add_option("--scene", o.scene,
                 "filter: kitchen, table or office, which the logs show; for its true surfaces")
      ->needs(only_option);
  app.add_option("--robot", o.robot, "landmarks: which one of an MRCLAM folder")->needs(only_option);
  app.add_option("--description", o.description, "landmarks: of the data set, as for import")
      ->check(CLI::ExistingFile)
      ->needs(only_option);
  app.add_option("--apart", o.features.apart, "features: frames between the images of a pair, ascending")
      ->delimiter(',')
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--starts", o.features.starts, "features: first images, spread over the recording")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--keypoints", o.features.keypoints, "features: at most, by response")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--method", o.method, "pairs: only methods with this in their name")->needs(only_option);
  app.add_option("--max-translation", o.pairs.max_translation, "pairs: m, of a right result")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--max-rotation", o.pairs.max_rotation, "pairs: degrees, of a right result")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--clock-offset", o.pairs.truth_offset,
                 "pairs, consistency: s, added to images' stamps for the truth's clock")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--minutes", o.faults.minutes,
                 "faults: that the runs take together; kills: that each of two runs takes")
      ->needs(only_option)
      ->capture_default_str();
  app.add_option("--laps", o.laps,
                 "endurance: of the kitchen, about a minute each; CPU is judged from twelve on")
      ->check(CLI::Range(3, 1000))
      ->needs(only_option)
      ->capture_default_str();
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  const bool own = std::find(own_studies().begin(), own_studies().end(), only) != own_studies().end();
  const bool report = !own && (!only.empty() || !out.empty() || quick);
  if (const auto problem = option_problem(own      ? only
                                          : report ? "report"
                                                   : "demo",
                                          given_options(app, seeds.size()))) {
    std::cerr << "lcmslam study: " << *problem << "\n";
    return 2;
  }
  if (report) return report_command(out, only, o.data, quick, seeds);
  if (!seeds.empty()) o.seeds = seeds;
  if (!own) {
    install_stop_signals(0);
    return study_demo({o.seeds, o.config, o.data, seconds, o.overrides});
  }
  if (app.count("--apart") > 0) o.pairs.apart = o.features.apart;
  if (app.count("--starts") > 0) o.pairs.starts = o.features.starts;
  return run_own_study(only, o);
}

}  // namespace lcmslam

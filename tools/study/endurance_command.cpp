#include "tools/study/endurance_command.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/run_folder.hpp"
#include "tools/study/endurance_study.hpp"
#include "tools/study/study_report.hpp"

namespace lcmslam {

/// The simulated kitchen at three frames a second, as logs/kitchen_drive.lcmlog has it: forty laps take about
/// a quarter of an hour.
int endurance_command(int laps, int seed, std::string config, const std::vector<std::string>& overrides) {
  keep_freed_memory();
  if (config.empty()) config = share_path("config/replay.yaml");
  EnduranceSettings settings;
  settings.simulation.scene = share_path("config/scenes/kitchen.yaml");
  settings.simulation.seed = static_cast<std::uint64_t>(seed);
  settings.simulation.frame_rate = 3;
  settings.simulation.laps = laps;
  settings.config = load_config(config, overrides);
  settings.folder = new_run_folder("study-endurance");
  std::cout << fmt::format(
                   "{} laps of the kitchen, seed {}, at {:g} frames a second (the live camera has 10), JPEG "
                   "quality {}; "
                   "CPU of handlers and of what runs beside them, without rendering\n",
                   laps, seed, settings.simulation.frame_rate, settings.jpeg_quality)
            << std::flush;
  int lap = 0;
  settings.after_lap = [&](const LapFigures& figures) {
    std::cout << fmt::format("lap {}: {:.1f} ms a frame, {:.1f} kB/s, {:.0f} MB, {:.0f} landmarks\n", ++lap,
                             figures.all, figures.traffic, figures.resident, figures.landmarks)
              << std::flush;
  };
  const EnduranceResult result = study_endurance(settings);
  const auto verdicts = judge_endurance(result.laps, result.stop_seconds);
  nlohmann::json report = endurance_json(result.laps, verdicts);
  report["seed"] = seed;
  report["stop_seconds"] = result.stop_seconds;
  write_report(settings.folder, report, endurance_table(result.laps) + "\n" + verdict_lines(verdicts));
  return std::all_of(verdicts.begin(), verdicts.end(), [](const auto& v) { return v.met(); }) ? 0 : 1;
}

}  // namespace lcmslam

#pragma once
// A robot that drives through the simulated kitchen for an hour, lap after lap, through the whole graph in
// one process as batch has it. Answers: does a place that is visited again cost more each time?

#include <filesystem>
#include <functional>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "tools/study/lap_figures.hpp"

namespace lcmslam {

struct EnduranceSettings {
  SimulationSettings simulation;  ///< with its laps
  int jpeg_quality = 50;
  ConfigNode config;
  std::filesystem::path folder;  ///< gets the maps
  std::function<void(const LapFigures&)> after_lap;
};

struct EnduranceResult {
  std::vector<LapFigures> laps;
  double stop_seconds = 0;  ///< from the last frame until all is smoothed and saved
};

/// Nothing of the drive is kept: frames are rendered one at a time. A lap is as many frames as another.
/// Throws ConfigError and std::invalid_argument.
EnduranceResult study_endurance(const EnduranceSettings& settings);

}  // namespace lcmslam

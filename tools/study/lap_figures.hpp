#pragma once
// What a lap of the endurance study cost and gave, and whether the last one costs what the third one did.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace lcmslam {

struct LapFigures {
  std::int64_t frames = 0;
  double seconds = 0;  ///< of the drive
  // CPU, ms a frame.
  double surf = 0, odometry = 0, fastslam = 0, icp = 0, map_server = 0;  ///< of each one's handlers
  double beside = 0;  ///< graph, smoothing and deforming, which run beside the handlers
  double all = 0;
  // Published, kB a second of the drive.
  double traffic = 0, fastslam_traffic = 0, icp_traffic = 0, graph_traffic = 0;
  // At the lap's end.
  double icp_memory = 0, resident = 0;  ///< MB: as icp counts its map, and of the process
  double landmarks = 0, keyframes = 0, graph_nodes = 0, graph_edges = 0;
  double fastslam_error = 0, icp_error = 0;  ///< m, RMS of the positions from the truth
};

/// One demand of the bar.
struct EnduranceVerdict {
  std::string what;
  double value = 0, least = 0, most = 0;  ///< met when least <= value <= most
  bool judged = true;                     ///< false: laps are too few for the two sides to be different ones
  bool met() const { return judged && value >= least && value <= most; }
};

/// Traffic and memory of the last lap as a share of the third's, landmarks as a share of the second's, and
/// how long it took to stop. CPU likewise, but as the median of five laps and in units of surf's, which does
/// the same in each lap. What a lap would be held against itself for is not judged: traffic and memory below
/// four laps, landmarks below three, CPU below twelve. Its value is NaN.
std::vector<EnduranceVerdict> judge_endurance(const std::vector<LapFigures>& laps, double stop_seconds);

std::string endurance_table(const std::vector<LapFigures>& laps);
std::string verdict_lines(const std::vector<EnduranceVerdict>& verdicts);
nlohmann::json endurance_json(const std::vector<LapFigures>& laps,
                              const std::vector<EnduranceVerdict>& verdicts);

}  // namespace lcmslam

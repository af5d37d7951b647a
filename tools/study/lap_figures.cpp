#include "tools/study/lap_figures.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include <lcmslam/evaluation/table.hpp>

namespace lcmslam {
namespace {

constexpr double most_growth = 1.05;                              // of the last lap against the third
constexpr double fewest_landmarks = 0.85, most_landmarks = 1.15;  // of the last lap against the second
constexpr double longest_stop = 5;                                // s
constexpr std::size_t averaged_laps = 5;  // a lap's CPU varies by 6 % with the machine alone

struct LapColumn {
  const char* heading;
  const char* name;  // in JSON
  double LapFigures::*value;
  int decimals;
};
constexpr LapColumn lap_columns[] = {
    {"surf ms", "surf_ms", &LapFigures::surf, 1},
    {"odometry", "odometry_ms", &LapFigures::odometry, 2},
    {"fastslam", "fastslam_ms", &LapFigures::fastslam, 1},
    {"icp", "icp_ms", &LapFigures::icp, 1},
    {"server", "map_server_ms", &LapFigures::map_server, 2},
    {"beside", "beside_ms", &LapFigures::beside, 1},
    {"all", "all_ms", &LapFigures::all, 1},
    {"all kB/s", "traffic_kb_s", &LapFigures::traffic, 1},
    {"fastslam", "fastslam_traffic_kb_s", &LapFigures::fastslam_traffic, 1},
    {"icp", "icp_traffic_kb_s", &LapFigures::icp_traffic, 1},
    {"graph", "graph_traffic_kb_s", &LapFigures::graph_traffic, 2},
    {"icp MB", "icp_memory_mb", &LapFigures::icp_memory, 1},
    {"resident", "resident_mb", &LapFigures::resident, 0},
    {"landmarks", "landmarks", &LapFigures::landmarks, 0},
    {"keyframes", "keyframes", &LapFigures::keyframes, 0},
    {"nodes", "graph_nodes", &LapFigures::graph_nodes, 0},
    {"edges", "graph_edges", &LapFigures::graph_edges, 0},
    {"fastslam m", "fastslam_error_m", &LapFigures::fastslam_error, 4},
    {"icp m", "icp_error_m", &LapFigures::icp_error, 4},
};

/// CPU of all in units of surf's, whose work no map makes more: it is the clock for how fast the machine was
/// in a lap. The median of five laps from `first` on, counted from 0.
double relative_cost(const std::vector<LapFigures>& laps, std::size_t first) {
  std::vector<double> costs;
  for (std::size_t i = first; i < std::min(first + averaged_laps, laps.size()); ++i)
    costs.push_back(laps[i].all / laps[i].surf);
  std::nth_element(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2), costs.end());
  return costs[costs.size() / 2];
}

}  // namespace

std::vector<EnduranceVerdict> judge_endurance(const std::vector<LapFigures>& laps, double stop_seconds) {
  if (laps.empty()) throw std::invalid_argument("no lap to judge");
  const LapFigures& last = laps.back();
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const auto of_last = [&](const char* what, double LapFigures::*figure, std::size_t lap, double least,
                           double most) {
    const bool judged = laps.size() > lap;
    const double share = judged ? last.*figure / (laps[lap - 1].*figure) : nothing;
    return EnduranceVerdict{what, share, least, most, judged};
  };
  constexpr std::size_t third = 2;  // counted from 0
  const bool apart = laps.size() >= third + 2 * averaged_laps;
  const double growth =
      apart ? relative_cost(laps, laps.size() - averaged_laps) / relative_cost(laps, third) : nothing;
  return {
      {"CPU a frame in units of surf's, last five laps / third to seventh", growth, 0, most_growth, apart},
      of_last("traffic, last lap / third", &LapFigures::traffic, 3, 0, most_growth),
      of_last("resident memory, last lap / third", &LapFigures::resident, 3, 0, most_growth),
      of_last("memory that icp counts, last lap / third", &LapFigures::icp_memory, 3, 0, most_growth),
      of_last("landmarks, last lap / second", &LapFigures::landmarks, 2, fewest_landmarks, most_landmarks),
      {"seconds to stop", stop_seconds, 0, longest_stop}};
}

std::string endurance_table(const std::vector<LapFigures>& laps) {
  std::vector<std::string> header = {"lap"};
  for (const LapColumn& column : lap_columns) header.emplace_back(column.heading);
  Table table(header);
  for (std::size_t i = 0; i < laps.size(); ++i) {
    std::vector<std::string> row = {std::to_string(i + 1)};
    for (const LapColumn& column : lap_columns)
      row.push_back(fixed_number(laps[i].*column.value, column.decimals));
    table.add(row);
  }
  return table.text();
}

std::string verdict_lines(const std::vector<EnduranceVerdict>& verdicts) {
  std::string text;
  for (const EnduranceVerdict& v : verdicts)
    text += fmt::format("{}: {}, {} ({}{:g})\n", v.what, fixed_number(v.value, 3),
                        !v.judged ? "not judged, laps are too few"
                        : v.met() ? "met"
                                  : "NOT MET",
                        v.least > 0 ? fmt::format("from {:g} to ", v.least) : "at most ", v.most);
  return text;
}

nlohmann::json endurance_json(const std::vector<LapFigures>& laps,
                              const std::vector<EnduranceVerdict>& verdicts) {
  nlohmann::json json = {{"laps", nlohmann::json::array()}, {"verdicts", nlohmann::json::array()}};
  for (const LapFigures& lap : laps) {
    nlohmann::json row = {{"frames", lap.frames}, {"seconds", lap.seconds}};
    for (const LapColumn& column : lap_columns)
      if (std::isfinite(lap.*column.value)) row[column.name] = lap.*column.value;
    json["laps"].push_back(row);
  }
  for (const EnduranceVerdict& v : verdicts)
    json["verdicts"].push_back({{"what", v.what},
                                {"value", v.value},
                                {"least", v.least},
                                {"most", v.most},
                                {"judged", v.judged},
                                {"met", v.met()}});
  return json;
}

}  // namespace lcmslam

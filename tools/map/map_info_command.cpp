#include <fmt/format.h>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include <lcmslam/map_store/file/map_file.hpp>
#include "tools/map/map_commands.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

/// With what lies beside the file while it is written.
std::uintmax_t bytes_of(const std::string& file) {
  std::error_code none;
  const std::uintmax_t beside = std::filesystem::file_size(file + "-wal", none);
  return std::filesystem::file_size(file) + (none ? 0 : beside);
}

std::string place_of(const StoredSession& session) {
  if (!session.T_map_session) return "its own frame";
  const Eigen::Vector3d at = session.T_map_session->translation();
  return fmt::format("joined at {:.2f} {:.2f} {:.2f} m: {}", at.x(), at.y(), at.z(), session.evidence);
}

nlohmann::json json_of(MapFile& map, const StoredSession& session, const std::string& name) {
  const SessionCounts n = map.counts(session.id);
  return {{"name", name},
          {"sender", session.sender},
          {"frame", session.frame},
          {"keyframes", n.clouds},
          {"nodes", n.keyframes},
          {"points", n.points},
          {"features", n.features},
          {"images", n.images},
          {"edges", n.edges},
          {"landmarks", n.landmarks},
          {"poses", map.trajectory(session.id).size()},
          {"joined", session.T_map_session.has_value()}};
}

void print_json(const std::string& file, MapFile& map) {
  nlohmann::json root = {{"schema", map.schema()}, {"bytes", bytes_of(file)}};
  root["versions"] = nlohmann::json::array();
  for (const StoredRun& run : map.runs()) root["versions"].push_back(run.version);
  root["sensors"] = nlohmann::json::array();
  for (const StoredCalibration& calibration : map.calibrations())
    root["sensors"].push_back(calibration.sensor);
  const auto sessions = map.sessions();
  const auto names = names_of(sessions);
  root["sessions"] = nlohmann::json::array();
  for (std::size_t i = 0; i < sessions.size(); ++i)
    root["sessions"].push_back(json_of(map, sessions[i], names[i]));
  std::cout << root.dump(2) << "\n";
}

void print_text(const std::string& file, MapFile& map) {
  const auto runs = map.runs();
  std::cout << fmt::format("{}: schema {}, {:.1f} MB, written by {} runs", file, map.schema(),
                           1e-6 * static_cast<double>(bytes_of(file)), runs.size());
  if (!runs.empty()) std::cout << ", the last of version " << runs.back().version;
  std::cout << "\n";
  std::map<std::string, int> cameras;  // of each sensor
  for (const StoredCalibration& calibration : map.calibrations()) cameras[calibration.sensor];
  for (const StoredCalibration& camera : map.cameras()) ++cameras[camera.sensor];
  for (const auto& [sensor, count] : cameras)
    std::cout << (count > 1 ? fmt::format("{} calibrations", count) : "calibration") << " of " << sensor
              << "\n";
  std::cout << fmt::format("{:20} {:>9} {:>10} {:>8} {:>7} {:>7} {:>9} {:>7}  {}\n", "session", "keyframes",
                           "points", "features", "nodes", "edges", "landmarks", "poses", "frame, place");
  const auto sessions = map.sessions();
  const auto names = names_of(sessions);
  bool thinned = false;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const SessionCounts n = map.counts(sessions[i].id);
    std::cout << fmt::format("{:20} {:9} {:10} {:8} {:7} {:7} {:9} {:7}  {}, {}\n", names[i], n.clouds,
                             n.points, n.features, n.keyframes, n.edges, n.landmarks,
                             map.trajectory(sessions[i].id).size(), sessions[i].frame, place_of(sessions[i]));
    thinned = thinned || n.clouds < n.keyframes;
  }
  if (thinned) std::cout << "keyframes are the graph's nodes that have a cloud\n";
}

}  // namespace

int map_info_command(int argc, char** argv) {
  std::string file;
  bool json = false;
  CLI::App app{"Shows what is in a map file, also while it is written.", "lcmslam map info"};
  app.add_option("file", file, "an .lcmslam file")->required();
  app.add_flag("--json", json, "for programs");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  MapFile map(file);
  json ? print_json(file, map) : print_text(file, map);
  return 0;
}

}  // namespace lcmslam

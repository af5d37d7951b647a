#pragma once
// What an operator does from the page with a robot that runs: saves and begins maps, names goals, drives.

#include <lcmslam/live_page/dead_man.hpp>
#include <lcmslam/runtime/publisher.hpp>
#include <lcmslam/web/board.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "procs/map-server/page/bus_log.hpp"
#include "procs/map-server/page/page_desk.hpp"

namespace lcmslam {

class OperatorActions {
 public:
  OperatorActions(const MapServerSettings& settings, MapServerNode& maps, Publisher& publisher, Board& board);

  /// What the settings allow.
  void offer(PageDesk& desk);
  /// Stops the robot of an operator who fell silent, and shows every browser which log is written; to be
  /// called often.
  void watch();
  /// Stops the robot of whoever drives: nothing is heard from here on.
  void end();

 private:
  nlohmann::json reset();
  nlohmann::json go_to(const nlohmann::json& request);
  void publish(const Drive& drive);
  void show_log();

  PageSettings settings_;
  MapServerNode& maps_;
  Publisher& publisher_;
  DeadMan dead_man_;
  Board& board_;
  BusLog log_;
  std::optional<std::filesystem::path> shown_log_;
};

}  // namespace lcmslam

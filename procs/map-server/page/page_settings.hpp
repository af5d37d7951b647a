#pragma once
#include <lcmslam/settings/settings.hpp>
#include <lcmslam/web/web_settings.hpp>

namespace lcmslam {

/// Section `map-server.page`: the live page (docs/LIVE_PAGE.md).
struct PageSettings {
  bool serve = true;
  WebSettings web;
  std::string title = "lcmslam";
  double map_period = 1;
  double robot_length = 0.75, robot_width = 0.55, robot_height = 1.4;
  std::string go_to_channel, drive_channel;
  double top_speed = 0.3, top_turn = 0.8;

  void describe(SettingsVisitor& s) {
    s.flag("serve", serve, "the live page is shown");
    s.section("web", web, "where it is shown, and to whom");
    s.text("title", title, "of the page");
    s.number("map_period", map_period, "s", {0.1, 60}, "between two looks at what has changed of the maps");
    s.number("robot_length", robot_length, "m", {0.05, 10}, "as it is drawn");
    s.number("robot_width", robot_width, "m", {0.05, 10}, "as it is drawn");
    s.number("robot_height", robot_height, "m", {0.05, 10}, "as it is drawn");
    s.text(
        "go_to_channel", go_to_channel,
        "of the pose_t that the page sends where an operator names a goal in the map; empty: none is sent");
    s.text("drive_channel", drive_channel,
           "of the twist_t by which an operator drives, e.g. TELEOP; empty: nobody drives");
    s.number("top_speed", top_speed, "m/s", {0, 10}, "of an operator");
    s.number("top_turn", top_turn, "rad/s", {0, 10}, "of an operator");
  }
};

}  // namespace lcmslam

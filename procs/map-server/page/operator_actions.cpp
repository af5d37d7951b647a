#include "procs/map-server/page/operator_actions.hpp"

#include <chrono>
#include <cmath>
#include <limits>

#include <lcmslam/live_page/show_on_board.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/twist_t.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

Utime wall_clock() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

double steady_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

OperatorActions::OperatorActions(const MapServerSettings& settings, MapServerNode& maps, Publisher& publisher,
                                 Board& board)
    : settings_(settings.page), maps_(maps), publisher_(publisher), board_(board), log_(settings.folder) {}

void OperatorActions::offer(PageDesk& desk) {
  desk.offer("save", [this](const json&, PageDesk::Client) -> json {
    command_t save{};
    save.name = "save";
    maps_.command(save);
    return {{"words", "what has changed is being saved"}};
  });
  desk.offer_slow("export", [this](const json& request, const PageDesk::Done& done) {
    map_request_t wanted{};
    wanted.kind = map_request_t::EXPORT;
    wanted.argument = page_text(request, "name");
    maps_.export_maps(wanted, [done](const std::vector<std::string>& files, const std::string& error) {
      done({{"files", files}}, error);
    });
  });
  desk.offer("reset", [this](const json&, PageDesk::Client) { return reset(); });
  desk.offer("log", [this](const json& request, PageDesk::Client) -> json {
    if (!request.contains("on") || !request["on"].is_boolean())
      throw std::invalid_argument("'on' must be true or false");
    return {{"file", (request["on"].get<bool>() ? log_.start() : log_.stop()).string()}};
  });
  if (!settings_.go_to_channel.empty())
    desk.offer("go_to", [this](const json& request, PageDesk::Client) { return go_to(request); });
  if (settings_.drive_channel.empty()) return;
  desk.offer("drive", [this](const json& request, PageDesk::Client who) -> json {
    const Drive wanted{page_number(request, "linear"), page_number(request, "angular")};
    publish(dead_man_.drive(who, wanted, steady_clock()));
    return json::object();
  });
  desk.on_gone([this](PageDesk::Client who) {
    if (const auto stop = dead_man_.gone(who)) publish(*stop);
  });
}

void OperatorActions::watch() {
  show_log();
  if (const auto stop = dead_man_.silent(steady_clock())) publish(*stop);
}

void OperatorActions::end() {
  if (const auto stop = dead_man_.silent(std::numeric_limits<double>::infinity())) publish(*stop);
}

/// To each mapper that is alive, with the confirmation that such a command needs (runtime/confirmation.hpp).
json OperatorActions::reset() {
  const MapServerNode::Shown shown = maps_.shown();
  if (shown.icp_pose == nullptr && shown.fastslam_pose == nullptr)
    throw std::runtime_error("no mapper has told a position: there is no map to begin anew");
  for (const auto& [mapper, pose] :
       {std::pair("icp", shown.icp_pose), std::pair("fastslam", shown.fastslam_pose)}) {
    if (pose == nullptr) continue;
    command_t command{};
    command.utime = wall_clock();
    command.target = mapper;
    command.name = "reset";
    command.n = 1;
    command.keys = {mapper};
    command.values = {std::to_string(pose->sender)};
    publisher_.publish("COMMAND", command);
  }
  return {{"words", "the mappers begin new maps; the old ones are kept"}};
}

json OperatorActions::go_to(const json& request) {
  pose_t goal{};
  goal.utime = wall_clock();
  goal.pos[0] = page_number(request, "x");
  goal.pos[1] = page_number(request, "y");
  const double yaw = page_number(request, "yaw");
  goal.orientation[0] = std::cos(yaw / 2);
  goal.orientation[3] = std::sin(yaw / 2);
  publisher_.publish(settings_.go_to_channel, goal);
  return {{"words", "the goal is sent"}};
}

void OperatorActions::show_log() {
  if (shown_log_ == log_.file()) return;
  shown_log_ = log_.file();
  PageItem item{"log", ""};
  item.header = {{"on", !shown_log_->empty()}, {"file", shown_log_->string()}};
  show_on(board_, std::move(item));
}

void OperatorActions::publish(const Drive& drive) {
  twist_t twist{};
  twist.utime = wall_clock();
  twist.linear[0] = settings_.top_speed * drive.linear;
  twist.angular[2] = settings_.top_turn * drive.angular;
  publisher_.publish(settings_.drive_channel, twist);
}

}  // namespace lcmslam

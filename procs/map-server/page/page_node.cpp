#include "procs/map-server/page/page_node.hpp"

#include <spdlog/spdlog.h>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/live_page/show_on_board.hpp>
#include <lcmslam/runtime/version.hpp>

namespace lcmslam {
namespace {

constexpr auto pause = std::chrono::milliseconds(20);  // between two looks: what the page asks waits so long

double steady_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

PageItem about(const MapServerSettings& settings, const PageDesk& desk) {
  PageItem item{"about", ""};
  const PageSettings& page = settings.page;
  item.header = {
      {"title", page.title}, {"version", lcmslam_version}, {"source", "live"}, {"can", desk.can()}};
  item.header["robot"] = {
      {"length", page.robot_length}, {"width", page.robot_width}, {"height", page.robot_height}};
  return item;
}

}  // namespace

PageNode::PageNode(const ConfigNode& config, Publisher& publisher)
    : settings_(MapServerNode::read(config)),
      maps_(settings_, publisher),
      feed_(board_, settings_.page),
      operator_(settings_, maps_, publisher, board_) {
  if (settings_.page.serve) serve();
}

void PageNode::serve() {
  operator_.offer(desk_);
  desk_.offer_questions([this](const Question& question) { return maps_.asked_map(question); });
  show_on(board_, about(settings_, desk_));
  WebServer::Handlers handlers;
  handlers.command = [this](std::uint64_t who, const std::string& request, const WebServer::Reply& reply) {
    desk_.take(who, request, reply);
  };
  handlers.closed = [this](std::uint64_t who) { desk_.gone(who); };
  try {
    server_ = std::make_unique<WebServer>(settings_.page.web, share_path("page"), board_, handlers);
    spdlog::info("the live page: {}", server_->address());
  } catch (const std::exception& error) {
    failure_ = error.what();
    spdlog::error("there is no live page, mapping goes on: {}", failure_);
  }
}

void PageNode::connect(Inputs& inputs) {
  maps_.connect(inputs);
  if (server_) feed_.connect(inputs);
}

std::optional<Node::Duration> PageNode::work() {
  const auto wanted = maps_.work();
  if (!server_) return wanted;
  desk_.serve();
  operator_.watch();
  feed_.show(maps_, steady_now(), server_->counts().clients > 0);
  return std::min<Duration>(wanted.value_or(pause), pause);
}

void PageNode::finish() {
  operator_.end();
  maps_.finish();
  server_.reset();
}

NodeReport PageNode::report() const {
  NodeReport report = maps_.report();
  if (!failure_.empty()) report.detail += (report.detail.empty() ? "" : "; ") + ("no live page: " + failure_);
  if (!server_) return report;
  const WebCounts web = server_->counts();
  report.refused += web.refused() + desk_.counts().refused;
  report.values.emplace_back("page_clients", static_cast<double>(web.clients));
  report.values.emplace_back("page_refused", static_cast<double>(web.refused()));
  report.values.emplace_back("page_commands", static_cast<double>(desk_.counts().done));
  report.values.emplace_back("page_commands_refused", static_cast<double>(desk_.counts().refused));
  return report;
}

}  // namespace lcmslam

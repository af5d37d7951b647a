#include "tools/page/log_page.hpp"

#include <fmt/format.h>
#include <algorithm>

#include <lcmslam/live_page/show_on_board.hpp>
#include <lcmslam/runtime/version.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

constexpr double longest_turn = 0.05;  // s; then whoever asks has his turn
constexpr double told_every = 0.2;     // s

double steady_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Nothing is kept, and what is derived is made in turn.
MapServerSettings viewer_settings(const ConfigNode& config) {
  MapServerSettings settings = MapServerNode::read(config.section("map-server"));
  settings.store.clear();
  settings.mode = "map";
  settings.map.clear();
  settings.places = false;
  settings.snapshot_period = 0;
  return settings;
}

}  // namespace

class LogPage::Silent : public Publisher {
 public:
  Silent() : Publisher(1) {}

 private:
  void send(const std::string&, const std::vector<std::uint8_t>&, Utime) override {}
};

LogPage::LogPage(const std::string& file, const ConfigNode& config, Board& board)
    : file_(file), config_(config), board_(board) {
  const LogContents contents = scan_log(file);
  const auto has = [&](const char* channel) { return contents.channels.count(channel) > 0; };
  computes_ = !has("ICP_POSE") && !has("FASTSLAM_POSE");
  if (computes_ && !has("CAMERA") && !has("FEATURES"))
    throw std::runtime_error(file + ": has neither a mapper's poses nor images or features to map from");
  first_ = contents.first;
  MessageReader reader(file);
  while (const auto event = reader.next()) last_ = std::max(last_, event->timestamp);
  begin();
}

LogPage::~LogPage() = default;

void LogPage::begin() {
  graph_.reset();
  feed_.reset();
  for (const char* channel : {"poses", "path", "particles", "landmarks", "graph", "points", "mesh", "grid",
                              "planes", "objects", "image", "report", "notices"})
    board_.remove(channel);
  reader_ = std::make_unique<MessageReader>(file_);
  publisher_ = std::make_unique<Silent>();
  const MapServerSettings settings = viewer_settings(config_);
  maps_ = std::make_unique<MapServerNode>(settings, *publisher_);
  feed_ = std::make_unique<PageFeed>(board_, settings.page);
  inputs_ = std::make_unique<Inputs>();
  maps_->connect(*inputs_);
  feed_->connect(*inputs_);
  if (computes_) {
    const auto to_page = [this](const BatchMessage& message) {
      inputs_->deliver(message.channel, message.bytes.data(), message.bytes.size());
    };
    graph_ = std::make_unique<BatchGraph>(
        config_, std::vector<std::string>{"surf", "odometry", "fastslam", "icp"}, 2, to_page);
  }
  shown_ = first_;
  due_ = static_cast<double>(first_);
  over_ = seeking_ = false;
  PageItem about{"about", ""};
  about.header = {{"title", std::filesystem::path(file_).filename().string()}, {"version", lcmslam_version}};
  about.header["source"] = "log";
  about.header["can"] = {"query", "play"};
  about.header["robot"] = {{"length", settings.page.robot_length},
                           {"width", settings.page.robot_width},
                           {"height", settings.page.robot_height}};
  show_on(board_, std::move(about));
}

void LogPage::offer(PageDesk& desk) {
  desk.offer("play", [this](const json& request, PageDesk::Client) { return control(request); });
  desk.offer_questions([this](const Question& question) { return maps_->asked_map(question); });
}

json LogPage::control(const json& request) {
  if (request.contains("speed")) {
    const double speed = page_number(request, "speed");
    if (speed < 0.05 || speed > 100) throw std::invalid_argument("'speed' must be from 0.05 to 100");
    speed_ = speed;
  }
  if (request.contains("at")) {
    const double at =
        std::clamp(page_number(request, "at"), static_cast<double>(first_), static_cast<double>(last_));
    if (at < static_cast<double>(shown_)) begin();  // a map that has grown cannot be made smaller
    due_ = at;
    seeking_ = true;
  }
  if (request.contains("playing")) {
    if (!request["playing"].is_boolean()) throw std::invalid_argument("'playing' must be true or false");
    playing_ = request["playing"].get<bool>();
    if (playing_ && over_) begin();
  }
  show_time();
  return json::object();
}

void LogPage::play(double now) {
  if (then_ >= 0) {
    if (playing_ && !seeking_) due_ += 1e6 * speed_ * (now - then_);
    feed_->stand((now - then_) * (playing_ ? 1 - std::min(speed_, 1.0) : 1));
  }
  then_ = now;
  due_ = std::min(due_, static_cast<double>(last_));
  const bool to_end = due_ >= static_cast<double>(last_);  // several events may have the last stamp
  const double until = steady_now() + longest_turn;
  while (!over_ && (to_end || static_cast<double>(shown_) < due_) && steady_now() < until) {
    if (const auto event = reader_->next())
      deliver(*event);
    else
      over_ = true;
  }
  if (over_) playing_ = false;
  const bool is_late = static_cast<double>(shown_) < due_;
  if (over_ || !is_late) seeking_ = false;
  // A machine that cannot keep up shows later, not with gaps.
  if (is_late && !seeking_ && playing_ && computes_) due_ = static_cast<double>(shown_);
  maps_->work();
  feed_->show(*maps_, now);
  if (now < next_told_) return;
  next_told_ = now + told_every;
  show_time();
}

void LogPage::deliver(const LogEventView& event) {
  shown_ = std::max(shown_, event.timestamp);
  const std::string channel(event.channel);
  if (channel == "COMMAND" || channel == "MAP_REQUEST") return;  // orders were for those who ran then
  inputs_->deliver(channel, event.data, event.size);
  if (graph_ && graph_->is_input(channel))
    graph_->deliver({channel, {event.data, event.data + event.size}, event.timestamp});
}

void LogPage::show_time() {
  PageItem item{"time", ""};
  item.header = {
      {"begin", first_}, {"now", shown_}, {"end", last_}, {"playing", playing_}, {"speed", speed_}};
  show_on(board_, std::move(item));
}

}  // namespace lcmslam

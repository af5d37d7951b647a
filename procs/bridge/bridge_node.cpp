#include "procs/bridge/bridge_node.hpp"

#include <fmt/format.h>
#include <cctype>
#include <thread>

#include <lcmslam/bridge/smaller_picture.hpp>
#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/messages/camera_messages.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t most_waiting = 1000;           // messages in the inbox
constexpr std::size_t enough_waiting = 2'000'000;    // bytes in the inbox: a tenth of a second of the bus
constexpr std::size_t most_in_one = 60'000;          // bytes of a keyframe's tile
constexpr std::chrono::seconds longest_hold{1};      // of the link, while the inbox is full
constexpr std::chrono::milliseconds period{20};      // of work()
constexpr std::chrono::seconds request_period{5};    // of asking the mappers for their maps
constexpr std::chrono::seconds longest_farewell{5};  // in which the map's last part still goes out
constexpr std::chrono::seconds shortest_recall{20};  // between two readings of what the broker keeps
constexpr std::chrono::seconds longest_recall{600};
constexpr double snapshot_bytes = 10'000;  // a second, that whole maps take at most

/// Bytes a second, as a mapper tells its map; 0: as many as come.
double bytes_of_the_bus(std::chrono::microseconds pace) {
  return pace.count() > 0 ? static_cast<double>(most_in_one) / std::chrono::duration<double>(pace).count()
                          : 0;
}

/// As a level of a topic.
std::string level(const std::string& text) {
  std::string level = text.substr(0, 40);
  for (char& c : level)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_') c = '_';
  return level.empty() ? "_" : level;
}

std::string map_key(std::int64_t sender, const std::string& frame) {
  return fmt::format("{:016x}/{}", static_cast<std::uint64_t>(sender), level(frame));
}

std::string piece_name(const std::string& channel, const std::string& key, int part) {
  return fmt::format("{}{}/{}", part_channel(channel), key, part);
}

}  // namespace

BridgeSettings BridgeNode::read(const ConfigNode& config) {
  return read_settings<BridgeSettings>(config);
}

BridgeNode::BridgeNode(const ConfigNode& config, Publisher& publisher, const MakeLink& make_link)
    : BridgeNode(read(config), publisher, make_link) {}

BridgeNode::BridgeNode(const Settings& settings, Publisher& publisher, const MakeLink& make_link)
    : settings_(settings),
      publisher_(publisher),
      rules_(bridge::parse_rules(settings.send)),
      outbox_(rules_, settings.limits()),
      bus_(bytes_of_the_bus(publisher.pace()), 2 * most_in_one),
      incoming_(bridge::parse_rules(settings.receive), settings.side) {
  BridgeEnds ends{settings.broker(), settings.topics(), {}, outbox_, {}, {}, {}};
  for (const bridge::ChannelRule& rule : bridge::parse_rules(settings.receive))
    ends.receive.push_back(rule.channel);
  for (const bridge::ChannelRule& rule : rules_) {
    const bool map = rule.channel == "FASTSLAM_LANDMARKS" || rule.channel == "ICP_GRAPH";  // numbers say more
    if (rule.rate > 0 && !map) thinned_.insert(rule.channel);
  }
  ends.next = [this](bridge::Time now) { return next(now); };
  ends.take = [this](const std::string& channel, const std::uint8_t* data, std::size_t size, bool kept) {
    take_incoming(channel, data, size, kept);
  };
  ends.recalls = [this] { return recalls_.load(); };
  link_ = make_link(ends);
}

BridgeNode::~BridgeNode() {
  let_the_link_go();
}

void BridgeNode::connect(Inputs& inputs) {
  for (const bridge::ChannelRule& rule : rules_) subscribe(inputs, rule);
}

/// The map's channels and pictures have a way of their own, of any other channel the newest goes as it is.
void BridgeNode::subscribe(Inputs& inputs, const bridge::ChannelRule& rule) {
  const std::string& channel = rule.channel;
  const bool robot = settings_.side == bridge::Side::robot;
  if (robot && (channel == "FASTSLAM_LANDMARKS" || channel == "ICP_GRAPH" || channel == "ICP_KEYFRAME"))
    carries_maps_ = true;
  if (robot && channel == "FASTSLAM_LANDMARKS") {
    inputs.subscribe<landmarks_t>(channel, 1000, [this](const landmarks_t& m) { landmarks_.hear(m); });
  } else if (robot && channel == "ICP_GRAPH") {
    inputs.subscribe<graph_t>(channel, 1000, [this](const graph_t& m) { graph_.hear(m); });
  } else if (robot && channel == "ICP_KEYFRAME") {
    keyframes_ =
        &inputs.subscribe<keyframe_t>(channel, 2000, [this](const keyframe_t& m) { on_keyframe(m); });
  } else if (robot && channel == "CAMERA") {
    inputs.subscribe<images_t>(channel, 1, [this](const images_t& m) { on_camera(m); });
  } else if (!robot && channel == "COMMAND") {
    inputs.subscribe<command_t>(channel, 200, [this](const command_t& m) { on_order(m); });
  } else {
    inputs.subscribe_bytes(channel, 200, [this, channel](const auto& bytes, const AnyMessage& message) {
      outbox_.put(channel, message.origin.sender, bytes, Clock::now());
    });
  }
}

/// Numbered anew where messages are left out, so that the other end counts as lost what was lost.
std::optional<bridge::Outgoing> BridgeNode::next(bridge::Time now) {
  auto out = outbox_.next(now);
  if (!out || out->kept || thinned_.count(out->name) == 0) return out;
  std::vector<std::uint8_t> bytes = *out->bytes;
  renumber(bytes, identify(bytes.data(), bytes.size()), out->number);
  out->bytes = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
  return out;
}

void BridgeNode::on_keyframe(const keyframe_t& message) {
  const std::string key =
      fmt::format("{}/{}/{}", map_key(message.sender, message.frame), message.id, message.tile);
  // A mapper that is asked for all tells most of it as it was.
  if (outbox_.holds("ICP_KEYFRAME", key, message.map_revision)) return;
  keep("ICP_KEYFRAME", key, encode_message(message), message.utime, message.map_revision);
}

/// The map comes late here by what the link takes. Who misses something of it asks the mappers; the broker
/// has what they would tell, and the robot and its link are spared.
void BridgeNode::on_order(const command_t& message) {
  if (message.name != "resend")
    return outbox_.put("COMMAND", message.sender, encode_message(message), Clock::now());
  const auto now = Clock::now();
  if (now < next_recall_) return;
  const bool rested = now > next_recall_ + recall_pause_;
  recall_pause_ = rested ? shortest_recall : std::min<Clock::duration>(2 * recall_pause_, longest_recall);
  next_recall_ = now + recall_pause_;
  ++recalls_;
}

void BridgeNode::on_camera(const images_t& message) {
  if (!outbox_.wants("CAMERA", Clock::now())) return;  // coding costs more than anything else here
  const auto smaller =
      bridge::smaller_picture(from_message(message), settings_.picture_width, settings_.picture_quality);
  images_t picture = to_message(smaller);
  const Origin from = origin(message);
  set_origin(picture, {numbers_[{"CAMERA", from.sender}]++, from.sender});
  outbox_.put("CAMERA", from.sender, encode_message(picture), Clock::now());
}

void BridgeNode::keep(const std::string& channel, const std::string& key,
                      const std::vector<std::uint8_t>& bytes, Utime utime, std::int64_t version) {
  outbox_.keep(channel, key, in_pieces(channel, "/" + key, bytes, utime), version);
}

/// A former run of this bridge may have left the same map's state of then in the other form, whole or in
/// pieces. Without the first piece it is none.
void BridgeNode::keep_snapshot(const std::string& channel, const std::string& key,
                               const std::vector<std::uint8_t>& bytes, Utime utime) {
  std::vector<bridge::Outbox::Piece> pieces = in_pieces(channel, "/" + key, bytes, utime);
  const bool is_whole = pieces.size() == 1;
  pieces.push_back({is_whole ? piece_name(channel, "/" + key, 0) : channel + "/" + key, {}});
  outbox_.keep(channel, key, std::move(pieces));
}

std::vector<bridge::Outbox::Piece> BridgeNode::in_pieces(const std::string& channel, const std::string& key,
                                                         const std::vector<std::uint8_t>& bytes,
                                                         Utime utime) {
  const auto piece = static_cast<std::size_t>(settings_.piece);
  if (bytes.size() <= piece) return {{channel + key, bytes}};
  std::vector<bridge::Outbox::Piece> pieces;
  for (part_t& part : split_message(channel, bytes, utime, split_++, piece)) {
    set_origin(part, {pieces_++, publisher_.sender()});
    pieces.push_back({piece_name(channel, key, part.part), encode_message(part)});
  }
  return pieces;
}

std::optional<Node::Duration> BridgeNode::work() {
  hand_on();
  if (carries_maps_) {
    tell_maps();
    ask_for_what_lacks();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  return inbox_.empty() ? Duration(period) : Duration(publisher_.pace());
}

void BridgeNode::tell_maps() {
  tell("FASTSLAM_LANDMARKS", landmarks_, landmark_snapshots_);
  tell("ICP_GRAPH", graph_, graph_snapshots_);
}

/// A change once those before it have arrived; from time to time, and after each new connection, all of it.
template <class Teller>
void BridgeNode::tell(const std::string& channel, Teller& teller, Snapshots& snapshots) {
  const auto now = Clock::now();
  if (!outbox_.wants(channel, now)) return;
  const std::int64_t connection = outbox_.connections();
  const bool whole = connection != snapshots.connection || now >= snapshots.next;
  const auto message = teller.tell(whole);
  if (!message) return;
  const std::vector<std::uint8_t> bytes = encode_message(*message);
  if constexpr (std::is_same_v<Teller, GraphRelay>)
    for (const std::int32_t gone : teller.gone())
      outbox_.forget("ICP_KEYFRAME", fmt::format("{}/{}/", map_key(teller.sender(), teller.frame()), gone));
  if (!whole) return outbox_.put(channel, 0, in_pieces(channel, "/change", bytes, message->utime), now);
  keep_snapshot(channel, map_key(teller.sender(), teller.frame()), bytes, message->utime);
  const double pause = settings_.snapshot_period + static_cast<double>(bytes.size()) / snapshot_bytes;
  snapshots.connection = connection;
  snapshots.next = now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(pause));
}

/// The mappers' whole maps: at the beginning, which may be late, and whenever a part was missed.
void BridgeNode::ask_for_what_lacks() {
  const auto now = Clock::now();
  if (now < next_request_) return;
  const std::int64_t lost = keyframes_ != nullptr ? keyframes_->senders.total().lost : 0;
  const bool icp = graph_.incomplete() || lost > keyframes_lost_ || asked_ == 0 || outbox_.lacks();
  const bool fastslam = landmarks_.incomplete() || asked_ == 0;
  if (!icp && !fastslam) return;
  keyframes_lost_ = lost;
  ++asked_;
  next_request_ = now + request_period;
  command_t command;
  command.utime = 0;
  command.name = "resend";
  command.target = icp && fastslam ? "" : icp ? "icp" : "fastslam";
  command.n = 0;
  publisher_.publish("COMMAND", command);
}

void BridgeNode::take_incoming(const std::string& channel, const std::uint8_t* data, std::size_t size,
                               bool kept) {
  std::unique_lock<std::mutex> lock(mutex_);
  // What more a broker keeps is safe there.
  room_.wait_for(lock, longest_hold, [this] { return inbox_bytes_ < enough_waiting || is_ending_; });
  const auto now = Clock::now();
  take_what_waited(now);
  if (auto message = incoming_.take(channel, data, size, kept, now)) into_inbox(std::move(*message));
}

void BridgeNode::take_what_waited(Clock::time_point now) {
  for (Incoming::Message& message : incoming_.due(now)) into_inbox(std::move(message));
}

void BridgeNode::into_inbox(Incoming::Message message) {
  if (inbox_.size() >= most_waiting) {
    inbox_bytes_ -= inbox_.front().bytes.size();
    inbox_.pop_front();
    ++inbox_drops_;
  }
  inbox_bytes_ += message.bytes.size();
  inbox_.push_back(std::move(message));
}

/// A whole map that the broker keeps comes at once. Receivers on the bus would lose most of it, and the same
/// each time that they ask for it again.
std::deque<Incoming::Message> BridgeNode::what_may_go() {
  std::deque<Incoming::Message> messages;
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto now = Clock::now();
  take_what_waited(now);
  while (!inbox_.empty() && bus_.try_take(static_cast<double>(inbox_.front().bytes.size()), now)) {
    inbox_bytes_ -= inbox_.front().bytes.size();
    messages.push_back(std::move(inbox_.front()));
    inbox_.pop_front();
  }
  handed_on_ += static_cast<std::int64_t>(messages.size());
  room_.notify_all();
  return messages;
}

void BridgeNode::hand_on() {
  for (Incoming::Message& message : what_may_go()) {
    // They come the newest first, and again only where they changed: gaps of their numbers are no losses.
    if (settings_.side == bridge::Side::operating && message.channel == "ICP_KEYFRAME") {
      const AnyMessage is = identify(message.bytes.data(), message.bytes.size());
      renumber(message.bytes, is, numbers_[{message.channel, is.origin.sender}]++);
    }
    publisher_.forward(message.channel, message.bytes, message.utime);
  }
}

/// What makes the map still goes out, if the broker is there.
void BridgeNode::finish() {
  let_the_link_go();
  const auto end = Clock::now() + longest_farewell;
  landmark_snapshots_.next = graph_snapshots_.next = Clock::now();
  while (Clock::now() < end && outbox_.is_connected()) {
    tell_maps();
    if (outbox_.idle()) break;
    std::this_thread::sleep_for(period);
  }
  link_.reset();
}

/// Nobody hands on what it would wait for.
void BridgeNode::let_the_link_go() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_ending_ = true;
  room_.notify_all();
}

NodeReport BridgeNode::report() const {
  NodeReport report;
  const bridge::OutboxCounts counts = outbox_.counts();
  const std::lock_guard<std::mutex> lock(mutex_);
  report.detail = link_ ? link_->state() : "closed";
  report.refused = incoming_.refused();
  if (incoming_.refused() > 0 && !incoming_.last_error().empty())
    report.detail += "; refused: " + incoming_.last_error();
  const auto add = [&](const char* name, auto value) {
    report.values.emplace_back(name, static_cast<double>(value));
  };
  add("connected", outbox_.is_connected() ? 1 : 0);
  add("connections", outbox_.connections());
  add("bridged", counts.sent);
  add("acknowledged", counts.acknowledged);
  add("replaced", counts.replaced);
  add("kept", counts.kept);
  add("kept_waiting", counts.waiting);
  add("kept_bytes", counts.kept_bytes);
  add("evicted", counts.evicted);
  add("sent_again", counts.again);
  add("window", counts.window);
  add("oldest", counts.age);
  add("taken", handed_on_);
  add("refused", incoming_.refused());
  add("recalls", recalls_.load());
  add("inbox_drops", inbox_drops_);
  add("incomplete", incoming_.incomplete());
  return report;
}

}  // namespace lcmslam

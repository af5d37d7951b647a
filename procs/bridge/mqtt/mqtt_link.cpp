#include "procs/bridge/mqtt/mqtt_link.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include <lcmslam/runtime/lcm_bus.hpp>

namespace lcmslam {
namespace {

constexpr std::chrono::milliseconds loop_wait{5};  // of each connection, where nothing comes
constexpr int most_at_once = 100;                  // packets, before what waits to go out is looked at
constexpr std::chrono::seconds mark_period{1};
constexpr std::chrono::seconds mark_patience{
    3};  // in which the broker tells what it kept, or has kept nothing
constexpr std::chrono::seconds connect_patience{15};
constexpr std::chrono::milliseconds first_pause{200};

bridge::Broker with_suffix(bridge::Broker broker, const char* suffix) {
  broker.id += suffix;
  return broker;
}

}  // namespace

/// What is done from an attempt to connect to the end. There are two connections, because on one all that
/// follows a lost packet waits for it: maps and pictures have one, all else, poses above all, the other.
class MqttLink::Session {
 public:
  Session(MqttLink& link, const bridge::Broker& broker)
      : link_(link),
        ends_(link.ends_),
        recalls_(ends_.recalls()),
        large_{MqttConnection(broker, ends_.topics.presence(), events(large_))},
        small_{MqttConnection(with_suffix(broker, "-small"), "", events(small_))} {}

  bool was_connected() const { return connected_; }

  void step() {
    if (!go_on()) {
      large_.connection.loop(loop_wait);
      small_.connection.loop(loop_wait);
    }
    const auto now = Clock::now();
    if (!connected_) {
      if (now > begin_ + connect_patience) throw std::runtime_error("no answer from the broker");
      return;
    }
    if (!marked_ && now > connected_at_ + mark_patience) broker_keeps(0);
    if (const std::int64_t recalls = ends_.recalls(); recalls != recalls_) {
      recalls_ = recalls;
      recall();
    }
    while (const auto out = ends_.next(now)) {
      Way& way = out->beside ? small_ : large_;
      const int message = way.connection.publish(ends_.topics.outgoing(out->name), out->bytes->data(),
                                                 out->bytes->size(), out->kept, out->lives);
      way.tickets[message] = out->ticket;
    }
    if (marked_ && now >= next_mark_) tell_mark(now);
  }

  /// The last words; waits a little for them to go out.
  void close() {
    if (!connected_) return;
    tell_mark(Clock::now());
    last_ = large_.connection.publish(ends_.topics.presence(), "0", 1, true, 0);
    const auto end = Clock::now() + std::chrono::seconds(2);
    while (last_ != 0 && Clock::now() < end) large_.connection.loop(loop_wait);
    small_.connection.disconnect();
    large_.connection.disconnect();
  }

 private:
  /// Whether anything came. A call of a connection reads one packet, and one that waits for its own would
  /// hold up the other's.
  bool go_on() {
    const std::uint64_t before = came_;
    for (int packets = 0; packets < most_at_once; ++packets) {
      const std::uint64_t last = came_;
      large_.connection.loop(std::chrono::milliseconds(0));
      small_.connection.loop(std::chrono::milliseconds(0));
      if (came_ == last) break;
    }
    return came_ != before;
  }

  struct Way {
    MqttConnection connection;
    bool connected = false;
    std::map<int, std::uint64_t> tickets{};
    std::int64_t refused = 0;
  };

  MqttConnection::Events events(Way& way) {
    return {[this, &way] { on_connected(way); }, [this, &way](int message) { on_acknowledged(way, message); },
            [this](const std::string& filter, const std::string& why) { on_unsubscribed(filter, why); },
            [this](const std::string& topic, const std::uint8_t* data, std::size_t size, bool kept) {
              on_message(topic, data, size, kept);
            }};
  }

  void on_connected(Way& way) {
    way.connected = true;
    if (!large_.connected || !small_.connected) return;
    connected_ = true;
    connected_at_ = Clock::now();
    large_.connection.publish(ends_.topics.presence(), "1", 1, true, 0);
    large_.connection.subscribe(ends_.topics.mark(), true);
    const bool with_kept = ends_.topics.incoming("").find("/from/") != std::string::npos;
    for (const std::string& channel : ends_.receive) {
      (bridge::is_large(channel) ? large_ : small_)
          .connection.subscribe(ends_.topics.incoming(channel), with_kept);
      large_.connection.subscribe(ends_.topics.incoming(part_channel(channel)), with_kept);
    }
    ends_.outbox.connected();
    if (ends_.outbox.connections() == 1) broker_keeps(0);  // nothing of this run
    link_.say("connected to " + ends_.broker.host);
    spdlog::info("connected to {}:{}", ends_.broker.host, ends_.broker.port);
  }

  /// Keyframes alone: what is kept of the other maps is older than what came since.
  void recall() {
    for (const std::string& channel : ends_.receive) {
      if (channel != "ICP_KEYFRAME") continue;
      large_.connection.subscribe(ends_.topics.incoming(channel), true);
      large_.connection.subscribe(ends_.topics.incoming(part_channel(channel)), true);
    }
  }

  void on_acknowledged(Way& way, int message) {
    ++came_;
    if (&way == &large_ && message == last_) last_ = 0;
    const auto found = way.tickets.find(message);
    if (found == way.tickets.end()) return;
    ends_.outbox.acknowledged(found->second, Clock::now());
    way.tickets.erase(found);
    if (way.connection.refused() > way.refused) {
      way.refused = way.connection.refused();
      if ((way.refused & (way.refused - 1)) == 0)
        spdlog::warn("the broker does not take what is sent ({} so far): may {} write below {}?", way.refused,
                     ends_.broker.user.empty() ? "this bridge" : ends_.broker.user,
                     ends_.topics.outgoing(""));
    }
  }

  /// The connection goes on: what else is subscribed comes.
  void on_unsubscribed(const std::string& filter, const std::string& why) {
    const std::string words = fmt::format("the broker refuses the subscription to {}: {}", filter, why);
    spdlog::warn("{}", words);
    link_.say(fmt::format("connected to {}; {}", ends_.broker.host, words));
  }

  void on_message(const std::string& topic, const std::uint8_t* data, std::size_t size, bool kept) {
    ++came_;
    if (topic == ends_.topics.mark())
      return on_mark(std::string(data, data + std::min<std::size_t>(size, 100)));
    const std::string channel = ends_.topics.channel_of(topic);
    if (!channel.empty()) ends_.take(channel, data, size, kept);
  }

  /// "RUN NUMBER"; another run's speaks of other messages.
  void on_mark(const std::string& text) {
    if (marked_) return;
    std::istringstream words(text);
    std::string run;
    std::uint64_t number = 0;
    if (!(words >> run >> number) || run != link_.run_) number = 0;
    broker_keeps(number);
  }

  void broker_keeps(std::uint64_t mark) {
    marked_ = true;
    told_ = mark;
    ends_.outbox.broker_keeps(mark);
  }

  void tell_mark(Clock::time_point now) {
    const std::uint64_t mark = ends_.outbox.mark();
    next_mark_ = now + mark_period;
    if (mark == told_) return;
    const std::string text = fmt::format("{} {}", link_.run_, mark);
    large_.connection.publish(ends_.topics.mark(), text.data(), text.size(), true, 0);
    told_ = mark;
  }

  MqttLink& link_;
  const BridgeEnds& ends_;
  std::int64_t recalls_;
  Way large_, small_;
  const Clock::time_point begin_ = Clock::now();
  Clock::time_point connected_at_{}, next_mark_{};
  bool connected_ = false, marked_ = false;
  std::uint64_t told_ = 0, came_ = 0;
  int last_ = 0;
};

MqttLink::MqttLink(BridgeEnds ends)
    : ends_(std::move(ends)),
      run_(fmt::format("{:x}", draw_sender())),
      state_("connects to " + ends_.broker.host) {
  if (ends_.broker.id.empty()) ends_.broker.id = "lcmslam-" + run_;
  thread_ = std::thread([this] { run(); });
}

MqttLink::~MqttLink() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  stopped_.notify_all();
  thread_.join();
}

void MqttLink::run() {
  auto pause = first_pause;
  while (!stop_) {
    std::optional<Session> session;
    try {
      session.emplace(*this, ends_.broker);
      while (!stop_) session->step();
      session->close();
    } catch (const std::runtime_error& error) {
      if (state() != error.what() && !stop_) spdlog::warn("{}: {}", ends_.broker.host, error.what());
      say(error.what());
    }
    ends_.outbox.disconnected();
    if (session && session->was_connected()) pause = first_pause;
    session.reset();
    std::unique_lock<std::mutex> lock(mutex_);
    stopped_.wait_for(lock, pause, [this] { return stop_.load(); });
    const auto longest = std::chrono::milliseconds(static_cast<int>(1000 * ends_.broker.longest_pause));
    pause = std::min(2 * pause, std::max(longest, first_pause));
  }
}

std::string MqttLink::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

void MqttLink::say(const std::string& state) {
  const std::lock_guard<std::mutex> lock(mutex_);
  state_ = state;
}

}  // namespace lcmslam

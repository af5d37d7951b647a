#include "tools/log/log_player.hpp"

#include <stdexcept>
#include <utility>

#include "tools/log/play_pace.hpp"
#include "tools/log/play_source.hpp"
#include "tools/process_channels.hpp"

namespace lcmslam {
namespace {

/// What odometry is made of, in the order in which it is preferred; empty: of the frames themselves.
std::string readings_of(const std::set<std::string>& channels) {
  for (const char* channel : {"ODOMETRY", "ENCODERS", "TWIST", "POSE_BODY"})
    if (channels.count(channel) > 0) return channel;
  return "";
}

class Player {
 public:
  Player(const PlaySettings& settings, PlayBus& bus)
      : bus_(bus),
        clock_(settings.speed),
        lockstep_(
            settings.answer_channels,
            std::chrono::duration_cast<Lockstep::Duration>(std::chrono::duration<double>(settings.patience)),
            settings.in_flight) {
    bus_.on_answer = [this](const std::string& channel, Utime utime) { lockstep_.answered(channel, utime); };
  }
  ~Player() { bus_.on_answer = nullptr; }

  /// `covered`: see LockstepOrder.
  void play(const LockstepOrder::Source& next, const std::function<bool()>& covered) {
    clock_.restart();
    while (const auto event = next()) {
      if (!event->frame.empty()) wait_for_answers(covered(), &Lockstep::ready);
      if (event->begins_session || leaps(event->event.timestamp)) restart();
      wait_until(clock_.due(event->event.timestamp, bus_.now()));
      wait_until(pace_.due(event->event.data.size(), bus_.now()));
      if (bus_.stopped()) return;
      bus_.send(event->event.channel, event->event.data, event->utime);
      ++counts_.messages;
      if (event->frame.empty()) continue;
      ++counts_.frames;
      lockstep_.sent(event->frame, bus_.now());
    }
    wait_for_answers(covered(), &Lockstep::done);
  }

  PlayCounts counts() const {
    PlayCounts counts = counts_;
    counts.answered = lockstep_.answered_by_all();
    counts.answers = lockstep_.counts();
    counts.log_seconds = clock_.played();
    return counts;
  }

 private:
  /// A time so much later than the one before is damaged: it is not waited for.
  bool leaps(Utime timestamp) {
    constexpr Utime longest_pause = 86'400'000'000;  // us
    const Utime before = std::exchange(last_, timestamp);
    return time_between(before, timestamp) > longest_pause;
  }
  void restart() {
    clock_.restart();
    lockstep_.restart();
  }
  void wait_until(PlayBus::Time time) {
    while (bus_.now() < time && !bus_.stopped()) bus_.wait_until(time);
  }
  void wait_for_answers(bool covered, bool (Lockstep::*enough)(Lockstep::Time)) {
    constexpr auto patience_without_odometry = std::chrono::milliseconds(500);
    if (!covered) {
      ++counts_.uncovered;
      lockstep_.shorten(patience_without_odometry);
    }
    while (!(lockstep_.*enough)(bus_.now()) && !bus_.stopped()) bus_.wait_until(lockstep_.deadline());
  }

  PlayBus& bus_;
  LogClock clock_;
  SocketPace pace_;
  Lockstep lockstep_;
  PlayCounts counts_;
  Utime last_ = 0;  // log time
};

}  // namespace

std::set<std::string> channels_to_play(const std::set<std::string>& in_log, const PlaySettings& settings) {
  const bool choose = settings.selection.channels.empty() && !settings.all_channels;
  const auto computed = computed_channels(in_log, settings.processes);
  std::set<std::string> chosen, measured;
  for (const auto& channel : in_log) {
    // Answers that were recorded would be taken for those of the live mappers.
    const bool answer = !settings.answer_channels.empty() &&
                        (channel == "STATUS" || settings.answer_channels.count(channel) > 0);
    if (answer || !settings.selection.has_channel(channel)) continue;
    chosen.insert(channel);
    if (computed.count(channel) == 0 && !is_told(channel)) measured.insert(channel);
  }
  return choose && !measured.empty() ? measured : chosen;
}

PlayCounts play_log(const std::string& file, const PlaySettings& settings, PlayBus& bus) {
  if (!(settings.speed >= 0 && settings.speed <= 1000))
    throw std::invalid_argument("--speed " + std::to_string(settings.speed) +
                                ": must be 0 (as fast as possible) to 1000");
  if (!(settings.patience > 0 && settings.patience <= 3600))
    throw std::invalid_argument("--patience " + std::to_string(settings.patience) +
                                ": must be seconds above 0, at most 3600");
  settings.selection.check();
  const LogContents contents = scan_log(file);
  settings.selection.check_channels(contents.channels, file);
  const auto channels = channels_to_play(contents.channels, settings);
  const bool lockstep = !settings.answer_channels.empty();
  if (lockstep && frames_of(channels).empty())
    throw std::runtime_error(file +
                             ": lockstep waits for answers to CAMERA (or FEATURES), which is not played");

  PlaySettings all = settings;
  // Without readings odometry comes from the images themselves: a depth image taken after its colour image is
  // covered by the next frame only.
  const std::string readings = readings_of(channels);
  if (readings.empty()) all.in_flight = 2;
  Player player(all, bus);
  const auto begin = bus.now();
  do {
    PlaySource source(file, settings.selection, channels, contents.first);
    LockstepOrder order([&] { return source.next(); }, readings);
    const std::int64_t before = player.counts().messages;
    if (lockstep)
      player.play([&] { return order.next(); }, [&] { return order.covered(); });
    else
      player.play([&] { return source.next(); }, [] { return true; });
    if (player.counts().messages == before && !bus.stopped())
      throw std::runtime_error(file + ": no event lies within the times and channels asked for");
  } while (settings.loop && !bus.stopped());
  PlayCounts counts = player.counts();
  counts.seconds = std::chrono::duration<double>(bus.now() - begin).count();
  return counts;
}

}  // namespace lcmslam

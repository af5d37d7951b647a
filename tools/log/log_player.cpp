#include "tools/log/log_player.hpp"

#include <stdexcept>
#include <utility>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tools/log/log_session.hpp"
#include "tools/log/message_facts.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/log/play_pace.hpp"

namespace lcmslam {
namespace {

/// The selected messages of a log, with what the player has to know of them.
class PlaySource {
 public:
  PlaySource(const std::string& file, const LogSelection& selection, std::set<std::string> channels,
             Utime first)
      : reader_(file), selection_(selection), channels_(std::move(channels)), first_(first) {}

  std::optional<PlayEvent> next() {
    while (const auto event = reader_.next()) {
      begins_ |= sessions_.begins(*event);
      const bool selected =
          channels_.count(std::string(event->channel)) > 0 && selection_.has_time(event->timestamp, first_);
      if (selected) return describe(*event);
    }
    return std::nullopt;
  }

 private:
  PlayEvent describe(const LogEventView& view) {
    PlayEvent play{view.copy(), message_utime(view.data, view.size).value_or(view.timestamp), {}, begins_};
    begins_ = false;
    if (view.channel == "CAMERA")
      play.frame = frame_times(view, play.utime);
    else if (view.channel == "CAMERA_CALIBRATION")
      calibrate(view);
    return play;
  }

  std::vector<Utime> frame_times(const LogEventView& view, Utime utime) const {
    std::vector<Utime> times{utime};
    try {
      for (const auto& image : decode_message<images_t>(view.data, view.size).images)
        for (const Utime offset : {Utime{0}, depth_offset_})
          times.push_back(time_between(-offset, image.utime));
    } catch (const DecodeError&) {  // a camera of another type
    }
    return times;
  }

  void calibrate(const LogEventView& view) {
    try {
      const double offset = decode_message<camera_calibration_t>(view.data, view.size).depth_clock_offset;
      if (std::abs(offset) < 10) depth_offset_ = static_cast<Utime>(1e6 * offset);
    } catch (const DecodeError&) {  // of another type
    }
  }

  MessageReader reader_;
  const LogSelection& selection_;
  std::set<std::string> channels_;
  Utime first_;
  SessionTracker sessions_;
  bool begins_ = false;
  Utime depth_offset_ = 0;  // us
};

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
  static const std::set<std::string> raw{"CAMERA", "CAMERA_CALIBRATION", "ENCODERS", "GROUND_TRUTH"};
  const bool choose = settings.selection.channels.empty() && !settings.all_channels;
  std::set<std::string> chosen, raw_chosen;
  for (const auto& channel : in_log) {
    // Answers that were recorded would be taken for those of the live mappers.
    const bool answer = !settings.answer_channels.empty() &&
                        (channel == "STATUS" || settings.answer_channels.count(channel) > 0);
    if (answer || !settings.selection.has_channel(channel)) continue;
    chosen.insert(channel);
    if (raw.count(channel) > 0) raw_chosen.insert(channel);
  }
  return choose && !raw_chosen.empty() ? raw_chosen : chosen;
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
  if (lockstep && channels.count("CAMERA") == 0)
    throw std::runtime_error(file + ": lockstep waits for answers to CAMERA, which is not played");

  PlaySettings all = settings;
  // Without wheels odometry comes from the images themselves: a depth image taken after its colour image is
  // covered by the next frame only.
  if (channels.count("ENCODERS") == 0) all.in_flight = 2;
  Player player(all, bus);
  const auto begin = bus.now();
  do {
    PlaySource source(file, settings.selection, channels, contents.first);
    LockstepOrder order([&] { return source.next(); });
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

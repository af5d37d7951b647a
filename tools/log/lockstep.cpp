#include "tools/log/lockstep.hpp"

#include <algorithm>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t most_frames = 32;  // that late answers may explain
constexpr Utime farthest = 250'000;      // us; answers farther from all frames belong to another replay
constexpr int most_missed = 3;           // frames in a row

}  // namespace

Lockstep::Lockstep(const std::set<std::string>& channels, Duration patience, int in_flight)
    : patience_(patience), in_flight_(in_flight) {
  for (const auto& channel : channels) {
    channels_[channel];
    counts_[channel];
  }
}

void Lockstep::sent(std::vector<Utime> utimes, Time now) {
  waiting_.push_back({n_frames_, now, now + patience_});
  frames_.push_back({n_frames_++, std::move(utimes)});
  if (frames_.size() > most_frames) frames_.pop_front();
}

void Lockstep::shorten(Duration patience) {
  if (waiting_.empty()) return;
  Waiting& last = waiting_.back();
  last.deadline = std::min(last.deadline, last.sent + patience);
}

std::optional<std::int64_t> Lockstep::explained(Utime utime) const {
  std::optional<std::int64_t> number;
  Utime nearest = farthest;
  for (const Frame& frame : frames_)
    for (const Utime time : frame.utimes) {
      const Utime distance = std::max(time_between(time, utime), time_between(utime, time));
      if (distance > nearest) continue;
      nearest = distance;
      number = frame.number;
    }
  return number;
}

void Lockstep::answered(const std::string& channel, Utime utime) {
  const auto found = channels_.find(channel);
  const auto number = explained(utime);
  if (found == channels_.end() || !number || *number <= found->second.newest) return;
  found->second.newest = *number;
  found->second.missed = 0;
  Count& count = counts_[channel];
  ++count.answered;
  count.silent = false;
}

// Whether all frames up to `number` are answered or given up.
bool Lockstep::settled(std::int64_t number, Time now) {
  while (!waiting_.empty() && settle(waiting_.front(), now)) waiting_.pop_front();
  return waiting_.empty() || waiting_.front().number > number;
}

bool Lockstep::settle(const Waiting& frame, Time now) {
  bool waits = false, all = true;
  for (const auto& [name, channel] : channels_) {
    if (channel.newest >= frame.number) continue;
    all = false;
    waits |= !counts_[name].silent;
  }
  if (waits && now < frame.deadline) return false;
  answered_by_all_ += all ? 1 : 0;
  for (const auto& [name, channel] : channels_)
    if (channel.newest < frame.number) give_up(name);
  return true;
}

void Lockstep::give_up(const std::string& name) {
  Count& count = counts_[name];
  ++count.given_up;
  const bool others = std::any_of(counts_.begin(), counts_.end(), [&](const auto& other) {
    return other.first != name && !other.second.silent;
  });
  if (++channels_[name].missed >= most_missed && others) count.silent = true;
}

}  // namespace lcmslam

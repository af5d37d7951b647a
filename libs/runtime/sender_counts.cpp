#include <lcmslam/runtime/sender_counts.hpp>

#include <algorithm>

namespace lcmslam {

void InputCount::follow(std::int64_t seq, std::int64_t known_missing, Utime utime) {
  constexpr std::int64_t largest_seq = std::int64_t{1} << 50;  // more are garbage
  constexpr std::int64_t most_missing = 1000;
  constexpr Utime replay_step = 1'000'000;   // us; a log that starts again goes back by more
  if (seq < 0 || seq > largest_seq) return;  // a foreign sender that does not number
  const bool went_back = numbered_utime_ > replay_step && utime < numbered_utime_ - replay_step;
  const bool replayed = seq <= last_seq && missing_.count(seq) == 0 && went_back;
  if (replayed) {
    last_seq = -1;
    missing_.clear();
  }
  numbered_utime_ = utime;
  if (last_seq < 0) {
    last_seq = seq;
  } else if (seq > last_seq) {
    lost += std::max<std::int64_t>(0, seq - last_seq - 1 - known_missing);
    for (std::int64_t gap = std::max(last_seq + 1, seq - most_missing); gap < seq; ++gap)
      missing_.insert(gap);
    while (missing_.size() > most_missing) missing_.erase(missing_.begin());
    last_seq = seq;
  } else if (missing_.erase(seq) > 0) {
    ++reordered;  // was counted as lost when its successor came
    if (lost > 0) --lost;
  } else {
    ++duplicates;
  }
}

void InputCount::add(const InputCount& other) {
  received += other.received;
  bytes += other.bytes;
  lost += other.lost;
  duplicates += other.duplicates;
  reordered += other.reordered;
}

InputCount& SenderCounts::of(std::int64_t sender) {
  constexpr std::size_t most_senders = 64;  // garbage must not grow the table for ever
  if (counts_.count(sender) == 0 && counts_.size() >= most_senders) {
    const auto oldest = std::min_element(heard_.begin(), heard_.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
    forgotten_.add(counts_.at(oldest->first));
    counts_.erase(oldest->first);
    heard_.erase(oldest);
  }
  heard_[sender] = ++turn_;
  return counts_[sender];
}

std::map<std::int64_t, InputCount> SenderCounts::table() const {
  auto all = counts_;
  if (forgotten_.received > 0 || forgotten_.lost > 0) all[0].add(forgotten_);
  return all;
}

InputCount SenderCounts::total() const {
  InputCount sum = forgotten_;
  for (const auto& [sender, count] : counts_) sum.add(count);
  return sum;
}

}  // namespace lcmslam

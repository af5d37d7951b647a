#include <lcmslam/cameras/image_pairs.hpp>

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace lcmslam {
namespace {

constexpr Utime time_began_anew = 1'000'000;  // us back
constexpr std::size_t known_pace = 8, most_intervals = 15;
// Of images that find no partner so many of a camera wait, and so long (us) by its stamps, whichever is more:
// a partner may come late, and may be silent.
constexpr std::size_t most_waiting = 8;
constexpr Utime longest_wait = 300'000;
constexpr Utime none = std::numeric_limits<Utime>::min(), all = std::numeric_limits<Utime>::max();

}  // namespace

bool ImagePairs::Stream::may_give(Utime latest) const {
  // The next one follows after the shortest of the last intervals, less a tenth: a camera's pace does not
  // double at once.
  const Utime least =
      intervals.size() < known_pace ? 0 : *std::min_element(intervals.begin(), intervals.end());
  const Utime soonest = least - least / 10;
  return !begun || last + std::max<Utime>(soonest, 1) <= latest;
}

std::optional<Utime> ImagePairs::Stream::nearest(Utime utime) const {
  if (waiting.empty()) return std::nullopt;
  const auto after = waiting.lower_bound(utime);
  if (after == waiting.begin()) return after->first;
  const Utime before = std::prev(after)->first;
  if (after == waiting.end() || utime - before <= after->first - utime) return before;
  return after->first;
}

bool ImagePairs::admit(Stream& stream, Utime stamp) {
  if (stream.begun && stamp <= stream.last) {
    if (stamp > stream.last - time_began_anew) return false;
    finish();
    for (auto& [utime, pair] : pairs_) begun_before_.push_back(std::move(pair));
    pairs_.clear();
    colours_ = depths_ = Stream();
  }
  if (stream.begun) stream.intervals.push_back(stamp - stream.last);
  if (stream.intervals.size() > most_intervals) stream.intervals.pop_front();
  stream.begun = true;
  stream.last = stamp;
  return true;
}

void ImagePairs::add_colour(CameraShot frame) {
  const Utime stamp = frame.utime;
  if (admit(colours_, stamp))
    colours_.waiting.emplace(stamp, std::move(frame));
  else
    ++counts_.unmatched_colour;
}

void ImagePairs::add_depth(CameraShot frame) {
  const Utime stamp = depth_time(frame);
  if (admit(depths_, stamp))
    depths_.waiting.emplace(stamp, std::move(frame));
  else
    ++counts_.unmatched_depth;
}

std::optional<CameraShot> ImagePairs::next() {
  while (decide(none)) {
  }
  give_up_overdue();
  std::optional<CameraShot> pair;
  if (!begun_before_.empty()) {
    pair = std::move(begun_before_.front());
    begun_before_.pop_front();
  } else if (!pairs_.empty() &&
             (colours_.waiting.empty() || pairs_.begin()->first < colours_.waiting.begin()->first)) {
    pair = std::move(pairs_.begin()->second);
    pairs_.erase(pairs_.begin());
  }
  return pair;
}

void ImagePairs::finish() {
  while (decide(all)) {
  }
}

bool ImagePairs::Stream::is_overdue() const {
  return waiting.size() > most_waiting && last - waiting.begin()->first > longest_wait;
}

/// Gives up waiting for the partners of the oldest alone: those of the others may only be late.
void ImagePairs::give_up_overdue() {
  for (const Stream* stream : {&colours_, &depths_}) {
    if (!stream->is_overdue()) continue;
    Utime given_up = stream->waiting.begin()->first;
    while (stream->is_overdue())
      if (!decide(given_up)) given_up += 1 + tolerance_;
  }
}

/// Whether no image of `other` that comes later can be nearer to `utime` than `nearest`, or, where nothing is
/// near, be near at all. Who lies up to `given_up` waits for none.
bool ImagePairs::is_settled(const Stream& other, Utime utime, std::optional<Utime> nearest,
                            Utime given_up) const {
  if (utime <= given_up) return true;
  const bool near = nearest && std::abs(*nearest - utime) <= tolerance_;
  return !other.may_give(utime + (near ? std::abs(*nearest - utime) - 1 : tolerance_));
}

/// Makes one pair, or finds one image to be without; false when nothing can be decided.
bool ImagePairs::decide(Utime given_up) {
  for (const auto& [colour, frame] : colours_.waiting) {
    const auto depth = depths_.nearest(colour);
    if (!is_settled(depths_, colour, depth, given_up)) continue;
    if (!depth || std::abs(*depth - colour) > tolerance_) {
      if (depth) last_miss_ = std::abs(*depth - colour);
      ++counts_.unmatched_colour;
      colours_.waiting.erase(colour);
      return true;
    }
    const auto back = colours_.nearest(*depth);
    if (back == colour && is_settled(colours_, *depth, back, given_up)) {
      make_pair(colour, *depth);
      return true;
    }
  }
  for (const auto& [depth, frame] : depths_.waiting) {
    const auto colour = colours_.nearest(depth);
    const bool near = colour && std::abs(*colour - depth) <= tolerance_;
    if (near || !is_settled(colours_, depth, colour, given_up)) continue;
    ++counts_.unmatched_depth;
    depths_.waiting.erase(depth);
    return true;
  }
  return false;
}

void ImagePairs::make_pair(Utime colour, Utime depth) {
  CameraShot pair = std::move(colours_.waiting.at(colour));
  const CameraShot& other = depths_.waiting.at(depth);
  pair.depth = other.depth;
  pair.depth_utime = other.depth_utime;
  pair.amplitude = other.amplitude;
  pairs_.emplace(colour, std::move(pair));
  ++counts_.pairs;
  colours_.waiting.erase(colour);
  depths_.waiting.erase(depth);
}

}  // namespace lcmslam

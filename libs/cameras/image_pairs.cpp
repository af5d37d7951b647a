#include <lcmslam/cameras/image_pairs.hpp>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <tuple>

namespace lcmslam {
namespace {

constexpr Utime time_began_anew = 1'000'000;  // us back
constexpr std::size_t longest_wait = 8;  // images of one camera: one whose partner is silent must not pile up

}  // namespace

bool ImagePairs::Stream::may_give(Utime latest) const {
  // The next one follows after the shortest interval so far, less a tenth: a camera's pace does not double at
  // once.
  return !begun || last + std::max<Utime>(least_interval - least_interval / 10, 1) <= latest;
}

bool ImagePairs::admit(Stream& stream, Utime stamp) {
  if (stream.begun && stamp <= stream.last) {
    if (stamp > stream.last - time_began_anew) return false;
    finish();
    finished_ = false;
    colours_ = depths_ = Stream();
  }
  const Utime interval = stamp - stream.last;
  if (stream.begun && (stream.least_interval == 0 || interval < stream.least_interval))
    stream.least_interval = interval;
  stream.begun = true;
  stream.last = stamp;
  return true;
}

void ImagePairs::add_colour(RgbdFrame frame) {
  if (admit(colours_, frame.utime))
    colours_.waiting.push_back(std::move(frame));
  else
    ++counts_.unmatched_colour;
}

void ImagePairs::add_depth(RgbdFrame frame) {
  if (admit(depths_, frame.depth_utime))
    depths_.waiting.push_back(std::move(frame));
  else
    ++counts_.unmatched_depth;
}

std::optional<RgbdFrame> ImagePairs::next() {
  while (pairs_.empty()) {
    const auto group = decided_group();
    if (!group) return std::nullopt;
    decide(*group);
  }
  RgbdFrame pair = std::move(pairs_.front());
  pairs_.pop_front();
  return pair;
}

void ImagePairs::finish() {
  finished_ = true;
  while (const auto group = decided_group()) decide(*group);
}

/// The first images that are linked, each to the next, by possible pairs.
ImagePairs::Group ImagePairs::front_group() const {
  const auto& colours = colours_.waiting;
  const auto& depths = depths_.waiting;
  Group g;
  if (colours.empty() || (!depths.empty() && depths.front().depth_utime < colours.front().utime))
    g.depths = 1;
  else
    g.colours = 1;
  for (bool grows = true; grows;) {
    grows = false;
    if (g.colours > 0 && g.depths < depths.size() &&
        depths[g.depths].depth_utime - colours[g.colours - 1].utime <= tolerance_)
      ++g.depths, grows = true;
    if (g.depths > 0 && g.colours < colours.size() &&
        colours[g.colours].utime - depths[g.depths - 1].depth_utime <= tolerance_)
      ++g.colours, grows = true;
  }
  return g;
}

std::optional<ImagePairs::Group> ImagePairs::decided_group() const {
  const auto& colours = colours_.waiting;
  const auto& depths = depths_.waiting;
  if (colours.empty() && depths.empty()) return std::nullopt;
  const Group g = front_group();
  // May an image that comes later be linked to the group's last one of the other camera?
  const bool colour_may_join = g.depths > 0 && g.colours == colours.size() &&
                               colours_.may_give(depths[g.depths - 1].depth_utime + tolerance_);
  const bool depth_may_join = g.colours > 0 && g.depths == depths.size() &&
                              depths_.may_give(colours[g.colours - 1].utime + tolerance_);
  const bool too_long = std::max(colours.size(), depths.size()) > longest_wait;
  if (finished_ || too_long || (!colour_may_join && !depth_may_join)) return g;
  return std::nullopt;
}

void ImagePairs::note_miss(Utime colour) {
  std::optional<Utime> nearest;
  for (const RgbdFrame& depth : depths_.waiting) {
    const Utime apart = std::abs(depth.depth_utime - colour);
    if (!nearest || apart < *nearest) nearest = apart;
  }
  if (nearest) last_miss_ = nearest;
}

void ImagePairs::decide(const Group& group) {
  std::vector<std::tuple<Utime, std::size_t, std::size_t>> possible;  // distance, colour, depth
  for (std::size_t c = 0; c < group.colours; ++c)
    for (std::size_t d = 0; d < group.depths; ++d) {
      const Utime apart = std::abs(colours_.waiting[c].utime - depths_.waiting[d].depth_utime);
      if (apart <= tolerance_) possible.emplace_back(apart, c, d);
    }
  std::sort(possible.begin(), possible.end());
  constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> depth_of(group.colours, none);
  std::vector<bool> taken(group.depths, false);
  for (const auto& [apart, c, d] : possible) {
    if (depth_of[c] != none || taken[d]) continue;
    depth_of[c] = d;
    taken[d] = true;
  }
  for (std::size_t c = 0; c < group.colours; ++c) {
    RgbdFrame& colour = colours_.waiting[c];
    if (depth_of[c] == none) {
      ++counts_.unmatched_colour;
      note_miss(colour.utime);
      continue;
    }
    RgbdFrame& depth = depths_.waiting[depth_of[c]];
    colour.depth = depth.depth;
    colour.depth_utime = depth.depth_utime;
    colour.amplitude = depth.amplitude;
    pairs_.push_back(std::move(colour));
    ++counts_.pairs;
  }
  counts_.unmatched_depth += std::count(taken.begin(), taken.end(), false);
  colours_.waiting.erase(colours_.waiting.begin(),
                         colours_.waiting.begin() + static_cast<std::ptrdiff_t>(group.colours));
  depths_.waiting.erase(depths_.waiting.begin(),
                        depths_.waiting.begin() + static_cast<std::ptrdiff_t>(group.depths));
}

}  // namespace lcmslam

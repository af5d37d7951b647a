#include <lcmslam/runtime/refusals.hpp>

#include <fmt/format.h>
#include <cmath>
#include <numeric>

namespace lcmslam {

const char* describe(Refusal refusal) {
  static constexpr std::array<const char*, refusal_kinds> words = {
      "from another machine",
      "addressed to this machine, not to the group",
      "no datagram of LCM",
      "ends within its header",
      "without a proper channel name",
      "of a message that is too large",
      "fragment number beyond their count",
      "fragment without data",
      "data beyond the end of their message",
      "fragments contradict each other",
      "fragments missing",
      "without the seal of this bus's key",
      "sealed before",
      "sealed at another time"};
  return words[static_cast<std::size_t>(refusal)];
}

std::string describe_other_time(double age) {
  return fmt::format(
      "messages sealed by the right key, but {:.1f} s {}: a recording, or let both machines' clocks follow "
      "one time server",
      std::abs(age), age < 0 ? "ahead of this machine's clock" : "ago by their sender's clock");
}

std::int64_t Refusals::foreign() const {
  return of(Refusal::foreign) + of(Refusal::not_group);
}

std::int64_t Refusals::unsealed() const {
  return of(Refusal::unsealed) + of(Refusal::replayed) + of(Refusal::other_time);
}

std::int64_t Refusals::malformed() const {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0}) - foreign() - unsealed() -
         incomplete();
}

std::string Refusals::text() const {
  std::string text;
  const auto add = [&](std::int64_t count, const std::string& what) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what;
  };
  add(foreign(), "packets of strangers (last " + last_stranger + ")");
  add(of(Refusal::unsealed), "messages not sealed by this bus's key");
  add(of(Refusal::replayed), "sealed messages that came again");
  add(of(Refusal::other_time), describe_other_time(last_age));
  if (unsealed() > 0) text += " (last on " + last_unsealed + ")";
  add(malformed(), "malformed (" + last_malformed + ")");
  add(incomplete(), "messages lacked fragments");
  return text;
}

}  // namespace lcmslam

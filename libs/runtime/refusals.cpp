#include <lcmslam/runtime/refusals.hpp>

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
      "sealed before"};
  return words[static_cast<std::size_t>(refusal)];
}

std::int64_t Refusals::foreign() const {
  return of(Refusal::foreign) + of(Refusal::not_group);
}

std::int64_t Refusals::unsealed() const {
  return of(Refusal::unsealed) + of(Refusal::replayed);
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
  add(unsealed(), "messages not sealed by this bus's key (last on " + last_unsealed + ")");
  add(malformed(), "malformed (" + last_malformed + ")");
  add(incomplete(), "messages lacked fragments");
  return text;
}

}  // namespace lcmslam

#include "tools/echo/echo_log.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdexcept>

#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/bus_reader.hpp>
#include "tools/log/message_facts.hpp"

namespace lcmslam {
namespace {

/// A regular expression that is asked once a channel.
class WantedChannels {
 public:
  explicit WantedChannels(const std::string& channels) : set_(pattern(channels)) {}

  bool holds(std::string_view channel) {
    const auto found = known_.find(channel);
    if (found != known_.end()) return found->second;
    const std::string name(channel);
    return known_.emplace(name, set_.holds(name)).first->second;
  }
  std::string seen() const {
    std::string names;
    for (const auto& [name, wanted] : known_) names += (names.empty() ? "" : ", ") + printable(name);
    return names;
  }

 private:
  static ChannelSet pattern(const std::string& channels) {
    try {
      return ChannelSet::matching(echo_pattern(channels));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(error.what());
    }
  }

  ChannelSet set_;
  std::map<std::string, bool, std::less<>> known_;
};

}  // namespace

std::int64_t echo_log(const EchoLogRequest& request, const EchoOptions& options,
                      const std::function<bool(const std::string&)>& print) {
  WantedChannels wanted(request.channels);
  EchoPrinter printer(options);
  LogReader reader(request.file, [&](std::string_view, const std::uint8_t* data, std::size_t size) {
    return check_message_of(options.types.of(data, size), data, size);
  });
  std::int64_t printed = 0;
  std::optional<Utime> first;
  while (const auto event = reader.next_view()) {
    if (!first) first = event->timestamp;
    const Utime begin = request.from ? request.from->utime(*first) : *first;
    const bool in_channel = wanted.holds(event->channel);
    if (!in_channel || (request.from && event->timestamp < begin)) continue;
    const double seconds = 1e-6 * static_cast<double>(time_between(begin, event->timestamp));
    if (request.seconds > 0 && seconds >= request.seconds) continue;
    const auto text = printer.print(std::string(event->channel), event->data, event->size);
    if (!text) continue;
    ++printed;
    if (!print(*text) || printed == request.count) return printed;
  }
  if (printed == 0)
    throw std::runtime_error(fmt::format(
        "{}: no message of channel '{}'{}; its channels are {}", request.file, printable(request.channels),
        request.from || request.seconds > 0 ? " in that time" : "", wanted.seen()));
  return printed;
}

}  // namespace lcmslam

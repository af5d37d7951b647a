#pragma once
// Where messages come from: the small interface between the bus and whoever reads it.

#include <chrono>
#include <optional>
#include <regex>
#include <set>

#include <lcmslam/runtime/bus_message.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/refusals.hpp>

namespace lcmslam {

/// Channels that a reader wants: some by name, or all that match a regular expression as a whole.
class ChannelSet {
 public:
  explicit ChannelSet(std::set<std::string> names) : names_(std::move(names)) {}
  /// Throws std::invalid_argument when the pattern is no regular expression.
  static ChannelSet matching(const std::string& pattern);

  bool holds(const std::string& channel) const;
  /// The same channels with a prefix.
  ChannelSet below(const std::string& prefix) const;
  /// Regular expressions for LCM's own subscriptions.
  std::vector<std::string> patterns() const;

 private:
  std::set<std::string> names_;
  std::string pattern_;
  std::optional<std::regex> expression_;
};

/// One thread reads; what is counted may be asked for by any.
class BusReader {
 public:
  virtual ~BusReader() = default;

  /// Waits up to `wait` for a message of the wanted channels; false when none came. Throws std::runtime_error
  /// when the bus cannot be read any more, or for now.
  virtual bool read(BusMessage& message, std::chrono::milliseconds wait) = 0;

  /// What came and was not taken. Other providers than udpm count nothing.
  virtual Refusals refusals() const { return {}; }

  /// Of the socket that is read; with other providers of all of this process's.
  virtual SocketState socket() const { return socket_state(); }
};

}  // namespace lcmslam

#pragma once
// A node is what a process does, without the process: constructed from its configuration and a
// publisher, one handler a message. The same class runs live, in batch and in tests.
//
// What it can be told stands in a struct of its own that describes itself: N::Settings, and N::read() reads
// it from the process's section, so that tools know the keys without making a node.

#include <chrono>
#include <optional>

#include <lcmslam/command_t.hpp>
#include <lcmslam/configuration/config.hpp>
#include <lcmslam/runtime/inputs.hpp>
#include <lcmslam/runtime/publisher.hpp>

namespace lcmslam {

/// What a node reports of itself in STATUS.
struct NodeReport {
  int state = 1;       ///< status_t's: RUNNING, FINISHED, FAILED ...
  std::string detail;  ///< in words
  /// That came to the node by other ways than its inputs (a page's requests, say) and was not taken, so far.
  std::int64_t refused = 0;
  std::vector<std::pair<std::string, double>> values;
};

class Node {
 public:
  using Duration = std::chrono::steady_clock::duration;

  virtual ~Node() = default;

  /// Registers the handlers.
  virtual void connect(Inputs& inputs) = 0;

  /// A source's own work (camera). Called after each message and when none comes; gives the time until it
  /// wants to be called again, or nothing when it never does.
  virtual std::optional<Duration> work() { return std::nullopt; }

  /// A COMMAND for this process other than "stop"; confirmed where that is needed (confirmation.hpp).
  virtual void command(const command_t&) {}

  /// A COMMAND for another process, or one that is not confirmed for this one.
  virtual void overhear(const command_t&) {}

  /// The last call: what waits is finished, what must be kept is saved.
  virtual void finish() {}

  virtual NodeReport report() const { return {}; }
};

}  // namespace lcmslam

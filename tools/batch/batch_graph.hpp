#pragma once
// The whole graph in one process, without sockets and clocks. A message and all that follows from it is
// worked off in waves: each node handles its messages of a wave in their order, nodes side by side; what
// they publish, in the order of its causes and then of the nodes, is the next wave. So the result depends
// on the messages alone and not on the number of threads.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/runtime/node.hpp>

namespace lcmslam {

struct BatchMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  Utime utime = 0;
};

class BatchGraph {
 public:
  /// Takes what the nodes publish, in an order that is the same on every run.
  using Sink = std::function<void(const BatchMessage&)>;

  /// `processes` by name (process_names() without camera); throws ConfigError for their wrong settings and
  /// std::invalid_argument for a name that cannot run in batch.
  BatchGraph(const ConfigNode& config, const std::vector<std::string>& processes, int threads, Sink sink);
  ~BatchGraph();

  /// True for channels that come from outside: no node of this graph makes them, and they are no orders.
  bool is_input(const std::string& channel) const;

  /// Handles a message and all that follows from it.
  void deliver(BatchMessage message);

  /// The nodes' last words, in their order.
  void finish();

  struct Refused {
    std::int64_t messages = 0;
    std::string last_reason;
  };
  struct Summary {
    std::string process;
    std::map<std::string, Refused> refused;  ///< by channel
    std::int64_t received = 0, decode_errors = 0, published = 0;
    double cpu_seconds = 0;  ///< of its handlers; what it does beside them does not count
    NodeReport report;
  };
  std::vector<Summary> summary() const;

 private:
  struct Member;
  void work_off(std::vector<BatchMessage> wave);
  void handle(const std::vector<BatchMessage>& wave);
  std::vector<BatchMessage> collect(std::size_t causes);

  std::vector<std::unique_ptr<Member>> members_;
  std::size_t threads_;
  Sink sink_;
};

}  // namespace lcmslam

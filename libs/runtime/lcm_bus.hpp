#pragma once
// The LCM bus of a live process: a publisher, and one thread that drains the sockets into queues.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "runtime/inputs.hpp"
#include "runtime/publisher.hpp"

namespace lcmslam {

using SteadyTime = std::chrono::steady_clock::time_point;

class LcmPublisher : public Publisher {
 public:
  LcmPublisher(lcm::LCM& lcm, std::int64_t sender) : Publisher(sender), lcm_(lcm) {}
  double cpu_time() const override;

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override;
  lcm::LCM& lcm_;
};

/// A message that waits for the node.
struct Arrival {
  Input* input = nullptr;
  std::vector<std::uint8_t> bytes;
  SteadyTime time;
  std::int64_t dropped = 0;  ///< messages of its queue that were thrown away just before it
};

/// Drains the bus without ever waiting for the node: when a queue is full, its oldest message goes.
class Receiver {
 public:
  Receiver(lcm::LCM& lcm, const Inputs& inputs);
  ~Receiver();
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  /// The message that came first of all that wait; false when none comes within the time.
  bool take(Arrival& arrival, std::chrono::steady_clock::duration wait);

  struct QueueCount {
    std::int64_t drops = 0;
    double oldest = 0;  ///< s, largest wait since the last call of counts()
  };
  std::map<const Input*, QueueCount> counts();

 private:
  struct Queue {
    Receiver* receiver = nullptr;
    Input* input = nullptr;
    lcm::Subscription* subscription = nullptr;
    std::deque<Arrival> waiting;
    QueueCount count;
    std::int64_t dropped = 0;  // since the last one was taken
    void receive(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  };
  void drain();

  lcm::LCM& lcm_;
  std::vector<std::unique_ptr<Queue>> queues_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Random number that marks a process, never 0.
std::int64_t draw_sender();

}  // namespace lcmslam

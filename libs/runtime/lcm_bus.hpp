#pragma once
// The LCM bus of a live process: a publisher, and one thread that drains the sockets into queues.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <thread>

#include <lcmslam/messages/parts.hpp>
#include <lcmslam/runtime/bus.hpp>
#include <lcmslam/runtime/inputs.hpp>
#include <lcmslam/runtime/outage.hpp>
#include <lcmslam/runtime/publisher.hpp>
#include <lcmslam/runtime/pulse.hpp>
#include <lcmslam/runtime/seal.hpp>

namespace lcmslam {

using SteadyTime = std::chrono::steady_clock::time_point;

/// Bytes of the largest message that a receiver on this machine, asking for the buffer that the URL names,
/// can be trusted to take whole: a quarter of what the kernel grants, because several senders share it and
/// the kernel counts more than the payload. Without UDP there is no limit.
std::size_t largest_whole_message(const std::string& lcm_url);

/// Puts bytes on the bus: as they are where receivers can hold them, else in paced pieces; under this robot's
/// name where it has one, sealed where the bus has a key.
class BusSender {
 public:
  /// Messages above `largest_whole` bytes go in pieces; see largest_whole_message().
  BusSender(lcm::LCM& lcm, std::int64_t sender, std::size_t largest_whole);
  /// Waits until all is out.
  ~BusSender();
  BusSender(const BusSender&) = delete;
  BusSender& operator=(const BusSender&) = delete;

  /// Returns when the last piece is out; of what takes long (a large graph) a thread sends the pieces, and
  /// what follows on its channel. Who sends a third such message on a channel waits for the first. Errors are
  /// logged: there is nothing that a sender could do.
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime);

  /// Messages that went out in pieces so far.
  std::int64_t split() const { return split_; }
  /// Messages and pieces that could not be sent so far.
  std::int64_t failed() const { return failed_; }

 private:
  struct Numbers {
    std::int64_t messages = 0, parts = 0;
  };
  struct Late {
    std::string channel;
    std::vector<std::uint8_t> bytes;
    Utime utime = 0;
    bool is_long = false;  // it takes long
  };
  void send_now(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime);
  void pause();
  std::int64_t next_message(const std::string& channel);
  Origin next_part(const std::string& channel);
  void publish(const std::string& channel, std::vector<std::uint8_t> bytes);
  void work();

  lcm::LCM& lcm_;
  std::int64_t sender_;
  std::size_t largest_whole_;
  std::string robot_;  // "dora/"
  std::atomic<std::int64_t> split_{0}, failed_{0};

  std::mutex bus_mutex_;  // guards what follows
  std::optional<Sealer> sealer_;
  std::map<std::string, Numbers> numbers_;
  std::map<std::string, Outage> outages_;  // by channel: one may be too much for the network, others not
  SteadyTime last_large_{};                // when the last datagram of about a piece's size went out

  std::mutex mutex_;  // guards what follows
  std::condition_variable wake_, out_;
  std::deque<Late> late_;  // the first is on its way
  bool stop_ = false;
  std::thread thread_;
};

class LcmPublisher : public Publisher {
 public:
  LcmPublisher(lcm::LCM& lcm, std::int64_t sender, std::size_t largest_whole)
      : Publisher(sender), sender_(lcm, sender, largest_whole) {}
  double cpu_time() const override;
  std::chrono::microseconds pace() const override;
  std::int64_t split() const { return sender_.split(); }
  std::int64_t failed() const { return sender_.failed(); }

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override;
  BusSender sender_;
};

/// A message that waits for the node.
struct Arrival {
  Input* input = nullptr;
  std::vector<std::uint8_t> bytes;
  SteadyTime time;
  std::vector<MessageIdentity> skipped{};  ///< messages of its queue that were thrown away just before it
  std::int64_t unreadable = 0;             ///< those of them that do not decode

  /// To its input, with the account of what was thrown away.
  void deliver() const;
};

/// Drains the bus without ever waiting for the node: when a queue is full, its oldest message goes.
/// Messages in pieces are put together here; nodes do not know of them.
class Receiver {
 public:
  /// Throws std::runtime_error when the bus cannot be listened to.
  Receiver(LcmBus& bus, const Inputs& inputs);
  ~Receiver();
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  /// The message that came first of all that wait; false when none comes within the time.
  bool take(Arrival& arrival, std::chrono::steady_clock::duration wait);

  struct QueueCount {
    std::int64_t drops = 0;
    std::int64_t bad_parts = 0;   ///< pieces that do not decode or contradict each other
    std::int64_t incomplete = 0;  ///< messages given up because pieces were missing
    double oldest = 0;            ///< s, largest wait since the last call of counts()
  };
  std::map<const Input*, QueueCount> counts();

  /// Channels of measurements on which messages came regularly and come no more.
  std::vector<std::string> stopped();

  /// What came from the network and was not taken, and the state of the socket.
  Refusals refusals() const { return reader_->refusals(); }
  /// Datagrams and pieces that nobody on this bus should have sent.
  std::int64_t refused();
  SocketState socket() const { return reader_->socket(); }

 private:
  struct Queue {
    Receiver* receiver = nullptr;
    Input* input = nullptr;
    PartAssembler assembler;
    std::deque<Arrival> waiting;
    QueueCount count;
    Pulse pulse;
    std::vector<MessageIdentity> skipped;  // since the last one was taken
    std::int64_t unreadable = 0;           // the same
    void receive_part(const std::vector<std::uint8_t>& bytes);
    void push(std::vector<std::uint8_t> bytes);
    void drop_oldest();
  };
  static std::set<std::string> channels_of(const Inputs& inputs);
  void drain();
  void hand_over(const BusMessage& message);
  void bound_pieces();

  std::unique_ptr<BusReader> reader_;
  std::vector<std::unique_ptr<Queue>> queues_;
  std::size_t most_piece_bytes_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Random number that marks a process, never 0.
std::int64_t draw_sender();

}  // namespace lcmslam

#pragma once
// Where nodes send their messages: the bus when live, a log in batch, memory in tests.

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/origin.hpp>

namespace lcmslam {

/// What went out on one channel.
struct OutputCount {
  std::int64_t sent = 0;
  std::int64_t bytes = 0;
  std::int64_t largest = 0;
  Utime last_utime = 0;
};

class Publisher {
 public:
  /// `sender` marks every message, see status_t.
  explicit Publisher(std::int64_t sender) : sender_(sender) {}
  virtual ~Publisher() = default;

  /// Numbers, counts and sends. `cause` is the utime of the message that this one answers, where that
  /// differs from its own utime (latency is measured from there).
  template <class M>
  void publish(const std::string& channel, M message, Utime cause = 0) {
    const std::lock_guard<std::mutex> lock(mutex_);
    set_origin(message, Origin{numbers_[channel]++, sender_});
    const std::vector<std::uint8_t> bytes = encode_message(message);
    count(channel, bytes.size(), message.utime);
    send(channel, bytes, message.utime);
    if (on_answer) on_answer(cause != 0 ? cause : message.utime);
  }

  /// Hands on another's message as it is: with its own number and sender.
  void forward(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime);

  std::int64_t sender() const { return sender_; }
  std::map<std::string, OutputCount> counts() const;

  /// CPU seconds of this thread; 0 in batch, where output must not depend on the machine.
  virtual double cpu_time() const { return 0; }

  /// Time to leave between the pieces of something big, so that receive buffers do not overrun; none where
  /// there are no buffers.
  virtual std::chrono::microseconds pace() const { return std::chrono::microseconds(0); }

  /// Called with the utime that was answered; the process measures latency with it.
  std::function<void(Utime)> on_answer;

 private:
  void count(const std::string& channel, std::size_t bytes, Utime utime);
  virtual void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) = 0;

  std::int64_t sender_;
  mutable std::mutex mutex_;
  std::map<std::string, OutputCount> counts_;
  std::map<std::string, std::int64_t> numbers_;  // of its own messages; those of others have theirs
};

}  // namespace lcmslam

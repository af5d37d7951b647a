#pragma once
// For readers that do other things between two messages: a thread of its own empties the socket meanwhile.

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include <lcmslam/runtime/bus_reader.hpp>

namespace lcmslam {

class BufferedReader : public BusReader {
 public:
  explicit BufferedReader(std::unique_ptr<BusReader> source);
  ~BufferedReader() override;
  BufferedReader(const BufferedReader&) = delete;
  BufferedReader& operator=(const BufferedReader&) = delete;

  bool read(BusMessage& message, std::chrono::milliseconds wait) override;
  Refusals refusals() const override { return source_->refusals(); }
  SocketState socket() const override { return source_->socket(); }

  /// Messages thrown away because the reader did not take them in time.
  std::int64_t dropped() const;

 private:
  void drain();
  void push(BusMessage message);

  std::unique_ptr<BusReader> source_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<BusMessage> waiting_;
  std::size_t bytes_ = 0;  // of those that wait
  std::int64_t dropped_ = 0;
  std::string error_;  // why the bus cannot be read; empty when it can
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace lcmslam

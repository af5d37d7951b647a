#pragma once
// A log in place of the bus: what is published becomes an .lcmlog.

#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/runtime/publisher.hpp>

namespace lcmslam {

/// Events stand at their messages' own times. The file is there once it is closed (log_writer.hpp); errors
/// are std::runtime_error that names it.
class LogPublisher : public Publisher {
 public:
  explicit LogPublisher(const std::string& file) : Publisher(1), log_(file) {}

  /// Of all messages so far.
  std::int64_t bytes() const;

  void close() { log_.close(); }

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override {
    log_.write(utime, channel, bytes);
  }

  LogWriter log_;
};

}  // namespace lcmslam

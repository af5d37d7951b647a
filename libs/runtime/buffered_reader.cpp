#include <lcmslam/runtime/buffered_reader.hpp>

#include <stdexcept>
#include <utility>

namespace lcmslam {
namespace {

// Long enough for the pauses of a busy machine and of a slow terminal.
constexpr std::size_t most_messages = 20'000;
constexpr std::size_t most_bytes = 256 << 20;
constexpr std::chrono::milliseconds period{50};  // in which a stop is seen

}  // namespace

BufferedReader::BufferedReader(std::unique_ptr<BusReader> source)
    : source_(std::move(source)), thread_([this] { drain(); }) {}

BufferedReader::~BufferedReader() {
  stop_ = true;
  thread_.join();
}

void BufferedReader::drain() {
  while (!stop_) try {
      BusMessage message;
      if (source_->read(message, period)) push(std::move(message));
    } catch (const std::runtime_error& error) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        error_ = error.what();
      }
      arrived_.notify_one();
      std::this_thread::sleep_for(period);  // do not spin while a provider reconnects
    }
}

void BufferedReader::push(BusMessage message) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (waiting_.size() >= most_messages || bytes_ + message.bytes.size() > most_bytes) {
      ++dropped_;
      return;
    }
    bytes_ += message.bytes.size();
    waiting_.push_back(std::move(message));
  }
  arrived_.notify_one();
}

bool BufferedReader::read(BusMessage& message, std::chrono::milliseconds wait) {
  std::unique_lock<std::mutex> lock(mutex_);
  arrived_.wait_for(lock, wait, [&] { return !waiting_.empty() || !error_.empty(); });
  if (!waiting_.empty()) {
    message = std::move(waiting_.front());
    waiting_.pop_front();
    bytes_ -= message.bytes.size();
    return true;
  }
  if (!error_.empty()) throw std::runtime_error(std::exchange(error_, {}));
  return false;
}

std::int64_t BufferedReader::dropped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return dropped_;
}

}  // namespace lcmslam

#include "tests/integration/support/bus.hpp"

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <lcmslam/runtime/options.hpp>
#include "tests/integration/support/environment.hpp"

namespace lcmslam::integration {
namespace {

/// Bytes that wait in the receive buffers of all UDP sockets: fifth column, "tx:rx" in hexadecimal.
unsigned long waiting_bytes() {
  std::ifstream table("/proc/net/udp");
  std::string line;
  std::getline(table, line);  // heading
  unsigned long sum = 0;
  while (std::getline(table, line)) {
    std::istringstream columns(line);
    std::string column;
    for (int i = 0; i < 5; ++i) columns >> column;
    const std::size_t colon = column.find(':');
    if (colon != std::string::npos) sum += std::stoul(column.substr(colon + 1), nullptr, 16);
  }
  return sum;
}

}  // namespace

Bus::Bus() : bus_(lcm_url_from_environment()) {
  if (!bus_.usable()) throw std::runtime_error("the test cannot use LCM");
  reader_ = bus_.listen(ChannelSet::matching(".*"));
  thread_ = std::thread([this] {
    BusMessage message;
    while (!stop_)
      if (reader_->read(message, std::chrono::milliseconds(50))) on_message(message);
  });
}

Bus::~Bus() {
  stop_ = true;
  thread_.join();
}

void Bus::publish(const std::string& channel, const Bytes& bytes) {
  if (bus_.lcm().publish(channel, bytes.data(), static_cast<unsigned>(bytes.size())) != 0)
    throw std::runtime_error(channel + ": cannot be sent");
}

void Bus::on_message(const BusMessage& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counts_[message.channel];
  newest_[message.channel] = message.bytes;
  if (message.channel != "STATUS") return;
  try {
    on_status(decode_message<status_t>(message.bytes.data(), message.bytes.size()));
  } catch (const DecodeError&) {
    // our own garbage
  }
}

void Bus::on_status(const status_t& status) {
  statuses_[status.process] = status;
  ++status_counts_[{status.process, status.pid}];
}

std::size_t Bus::count(const std::string& channel) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = counts_.find(channel);
  return found == counts_.end() ? 0 : found->second;
}

Bytes Bus::newest(const std::string& channel) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = newest_.find(channel);
  return found == newest_.end() ? Bytes() : found->second;
}

std::optional<status_t> Bus::status(const std::string& process) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = statuses_.find(process);
  if (found == statuses_.end()) return std::nullopt;
  return found->second;
}

std::size_t Bus::status_count(const std::string& process, std::int64_t pid) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = status_counts_.find({process, pid});
  return found == status_counts_.end() ? 0 : found->second;
}

bool Bus::wait_for_status(const std::string& process, const std::function<bool(const status_t&)>& accepts,
                          double seconds) const {
  return wait_until(
      [&] {
        const auto newest_status = status(process);
        return newest_status && accepts(*newest_status);
      },
      seconds);
}

void Bus::wait_until_taken() const {
  wait_until([] { return waiting_bytes() == 0; }, 10);
}

double value_of(const status_t& status, const std::string& name) {
  for (const auto& value : status.values)
    if (value.name == name) return value.value;
  return std::nan("");
}

}  // namespace lcmslam::integration

#include "runtime/lcm_bus.hpp"

#include <spdlog/spdlog.h>

#include <ctime>
#include <random>
#include <utility>

namespace lcmslam {

double LcmPublisher::cpu_time() const {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void LcmPublisher::send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime) {
  if (lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size())) != 0)
    spdlog::error("{}: LCM could not send {} bytes", channel, bytes.size());
}

Receiver::Receiver(lcm::LCM& lcm, const Inputs& inputs) : lcm_(lcm) {
  for (const auto& input : inputs.all()) {
    auto queue = std::make_unique<Queue>();
    queue->receiver = this;
    queue->input = input.get();
    // LCM's own queue drops the newest: keep it long, ours decides.
    queue->subscription = lcm_.subscribe(input->channel(), &Queue::receive, queue.get());
    queue->subscription->setQueueCapacity(1000);
    queues_.push_back(std::move(queue));
  }
  thread_ = std::thread([this] { drain(); });
}

Receiver::~Receiver() {
  stop_ = true;
  thread_.join();
  for (const auto& queue : queues_) lcm_.unsubscribe(queue->subscription);
}

void Receiver::drain() {
  while (!stop_) {
    if (lcm_.handleTimeout(50) < 0) {
      spdlog::error("LCM stopped receiving");
      std::this_thread::sleep_for(std::chrono::milliseconds(50));  // do not spin while a provider reconnects
    }
  }
}

void Receiver::Queue::receive(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto* data = static_cast<const std::uint8_t*>(buffer->data);
  Arrival arrival{input, {data, data + buffer->data_size}, std::chrono::steady_clock::now(), 0};
  {
    const std::lock_guard<std::mutex> lock(receiver->mutex_);
    waiting.push_back(std::move(arrival));
    if (waiting.size() > input->capacity()) {
      waiting.pop_front();
      ++count.drops;
      ++dropped;
    }
  }
  receiver->arrived_.notify_one();
}

bool Receiver::take(Arrival& arrival, std::chrono::steady_clock::duration wait) {
  std::unique_lock<std::mutex> lock(mutex_);
  Queue* first = nullptr;
  const auto find_first = [&] {
    first = nullptr;
    for (const auto& queue : queues_)
      if (!queue->waiting.empty() &&
          (first == nullptr || queue->waiting.front().time < first->waiting.front().time))
        first = queue.get();
    return first != nullptr;
  };
  if (!arrived_.wait_for(lock, wait, find_first)) return false;
  arrival = std::move(first->waiting.front());
  first->waiting.pop_front();
  arrival.dropped = std::exchange(first->dropped, 0);
  const std::chrono::duration<double> age = std::chrono::steady_clock::now() - arrival.time;
  first->count.oldest = std::max(first->count.oldest, age.count());
  return true;
}

std::map<const Input*, Receiver::QueueCount> Receiver::counts() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::map<const Input*, QueueCount> result;
  for (const auto& queue : queues_) {
    result[queue->input] = queue->count;
    queue->count.oldest = 0;
  }
  return result;
}

std::int64_t draw_sender() {
  std::random_device device;
  const std::uint64_t bits = (static_cast<std::uint64_t>(device()) << 32) ^ device();
  return static_cast<std::int64_t>((bits >> 1) | 1);
}

}  // namespace lcmslam

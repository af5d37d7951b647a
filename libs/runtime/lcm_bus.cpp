#include <lcmslam/runtime/lcm_bus.hpp>

#include <spdlog/spdlog.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <limits>
#include <random>
#include <utility>

#include <lcmslam/runtime/bus_robot.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include <lcmslam/runtime/udpm/reassembly.hpp>

namespace lcmslam {
namespace {

// One datagram a piece. A quiet machine needs half a millisecond between them; on a busy one a receiver may
// have to wait for its core while they pile up, and the kernel's default buffer holds three or four.
constexpr std::size_t part_size = 60'000;  // bytes
constexpr std::chrono::microseconds part_period{3000};
constexpr std::size_t most_at_once = 1'000'000;  // bytes: 50 ms, that a sender may wait
constexpr std::ptrdiff_t most_late = 2;          // larger messages of a channel

}  // namespace

double LcmPublisher::cpu_time() const {
  return thread_cpu_seconds();
}

std::chrono::microseconds LcmPublisher::pace() const {
  return part_period;
}

void LcmPublisher::send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) {
  sender_.send(channel, bytes, utime);
}

std::size_t largest_whole_message(const std::string& lcm_url) {
  const MulticastAddress address = multicast_address(lcm_url);
  if (address.group.empty()) return std::numeric_limits<std::size_t>::max();
  const auto trusted = static_cast<std::size_t>(granted_receive_buffer(address.receive_buffer) / 4);
  return std::min(trusted, udpm::largest_message);  // of more not even its fragments are taken
}

BusSender::BusSender(lcm::LCM& lcm, std::int64_t sender, std::size_t largest_whole)
    : lcm_(lcm), sender_(sender), largest_whole_(largest_whole), robot_(robot_prefix()) {
  if (const auto key = bus_key()) sealer_.emplace(*key, draw_sender());
}

BusSender::~BusSender() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void BusSender::send(const std::string& name_of_channel, const std::vector<std::uint8_t>& bytes,
                     Utime utime) {
  const std::string channel = robot_ + name_of_channel;
  const bool is_long = bytes.size() > std::max(largest_whole_, most_at_once);
  const auto waiting = [&](bool long_alone) {
    return std::count_if(late_.begin(), late_.end(), [&](const Late& late) {
      return late.channel == channel && (late.is_long || !long_alone);
    });
  };
  std::unique_lock<std::mutex> lock(mutex_);
  if (!is_long && waiting(false) == 0) {
    lock.unlock();
    return send_now(channel, bytes, utime);
  }
  if (is_long) out_.wait(lock, [&] { return waiting(true) < most_late; });
  late_.push_back({channel, bytes, utime, is_long});
  if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
  wake_.notify_all();
}

void BusSender::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stop_ || !late_.empty(); });
    if (late_.empty()) return;
    const Late& late = late_.front();  // others come behind it
    lock.unlock();
    send_now(late.channel, late.bytes, late.utime);
    lock.lock();
    late_.pop_front();
    out_.notify_all();
  }
}

void BusSender::send_now(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) {
  if (bytes.size() <= std::max(largest_whole_, part_size)) return publish(channel, bytes);
  const std::string name = part_channel(channel);
  for (part_t& part : split_message(channel, bytes, utime, next_message(channel), part_size)) {
    if (part.part > 0) pause();
    set_origin(part, next_part(channel));
    publish(name, encode_message(part));
  }
  ++split_;
}

std::int64_t BusSender::next_message(const std::string& channel) {
  const std::lock_guard<std::mutex> lock(bus_mutex_);
  return numbers_[channel].messages++;
}

Origin BusSender::next_part(const std::string& channel) {
  const std::lock_guard<std::mutex> lock(bus_mutex_);
  return {numbers_[channel].parts++, sender_};
}

/// Also after what others send beside it: receivers have one buffer for all.
void BusSender::pause() {
  while (true) {
    std::unique_lock<std::mutex> lock(bus_mutex_);
    const SteadyTime end = last_large_ + part_period;
    lock.unlock();
    if (std::chrono::steady_clock::now() >= end) return;
    std::this_thread::sleep_until(end);
  }
}

void BusSender::publish(const std::string& channel, std::vector<std::uint8_t> bytes) {
  const std::lock_guard<std::mutex> lock(bus_mutex_);
  if (bytes.size() > part_size / 2) last_large_ = std::chrono::steady_clock::now();
  if (sealer_) sealer_->seal(channel, bytes, std::chrono::system_clock::now());
  Outage& outage = outages_[channel];
  errno = 0;
  if (lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size())) == 0) {
    if (const std::int64_t failures = outage.over(); failures > 0)
      spdlog::info("{}: LCM sends again, {} were not sent", channel, failures);
    return;
  }
  const std::string why = errno == 0 ? "" : std::string(": ") + std::strerror(errno);
  ++failed_;
  if (outage.failed())
    spdlog::error("{}: LCM could not send {} bytes{} ({} so far; ./lcmslam doctor says what the bus lacks)",
                  channel, bytes.size(), why, outage.failures());
}

void Arrival::deliver() const {
  for (const MessageIdentity& message : skipped) input->skip(message);
  input->deliver(bytes.data(), bytes.size(), unreadable);
}

Receiver::Receiver(LcmBus& bus, const Inputs& inputs)
    : reader_(bus.listen(ChannelSet(channels_of(inputs)))),
      most_piece_bytes_(udpm::reassembly_limits().bytes) {
  for (const auto& input : inputs.all()) {
    auto queue = std::make_unique<Queue>();
    queue->receiver = this;
    queue->input = input.get();
    queue->assembler = PartAssembler(most_piece_bytes_);
    queues_.push_back(std::move(queue));
  }
  thread_ = std::thread([this] { drain(); });
}

Receiver::~Receiver() {
  stop_ = true;
  thread_.join();
}

std::set<std::string> Receiver::channels_of(const Inputs& inputs) {
  std::set<std::string> channels;
  for (const auto& input : inputs.all()) channels.insert({input->channel(), part_channel(input->channel())});
  return channels;
}

void Receiver::drain() {
  constexpr std::chrono::milliseconds period{50};  // in which a stop is seen
  Outage outage;
  while (!stop_) try {
      BusMessage message;
      const bool came = reader_->read(message, period);
      if (outage.over() > 0) spdlog::info("the bus can be read again");
      if (came) hand_over(message);
    } catch (const std::runtime_error& error) {
      if (outage.failed()) spdlog::error("{} ({} so far)", error.what(), outage.failures());
      std::this_thread::sleep_for(period);  // do not spin while a provider reconnects
    }
}

void Receiver::hand_over(const BusMessage& message) {
  for (const auto& queue : queues_)
    if (message.channel == queue->input->channel())
      queue->push(message.bytes);
    else if (message.channel == part_channel(queue->input->channel()))
      queue->receive_part(message.bytes);
  if (is_part_channel(message.channel)) bound_pieces();
}

/// As the fragments' bound, of all channels together. Whose pieces take most pays, so that a flood on one
/// channel costs the others nothing.
void Receiver::bound_pieces() {
  const auto bytes = [](const auto& queue) { return queue->assembler.waiting_bytes(); };
  const auto less = [&](const auto& a, const auto& b) { return bytes(a) < bytes(b); };
  const auto sum = [&] {
    std::size_t all = 0;
    for (const auto& queue : queues_) all += bytes(queue);
    return all;
  };
  while (sum() > most_piece_bytes_) {
    Queue& largest = **std::max_element(queues_.begin(), queues_.end(), less);
    largest.assembler.give_up_oldest();
    const std::lock_guard<std::mutex> lock(mutex_);
    largest.count.incomplete = largest.assembler.incomplete();
  }
}

void Receiver::Queue::receive_part(const std::vector<std::uint8_t>& bytes) {
  try {
    const auto part = decode_message<part_t>(bytes.data(), bytes.size());
    if (part.channel != input->channel() && without_robot(part.channel) != input->channel())
      throw DecodeError("part_t of another channel");
    auto whole = assembler.add(part);
    {
      const std::lock_guard<std::mutex> lock(receiver->mutex_);
      count.incomplete = assembler.incomplete();
    }
    if (whole) push(std::move(whole->bytes));
  } catch (const DecodeError&) {
    const std::lock_guard<std::mutex> lock(receiver->mutex_);
    ++count.bad_parts;
  }
}

void Receiver::Queue::push(std::vector<std::uint8_t> bytes) {
  Arrival arrival{input, std::move(bytes), std::chrono::steady_clock::now()};
  {
    const std::lock_guard<std::mutex> lock(receiver->mutex_);
    pulse.beat(arrival.time);
    waiting.push_back(std::move(arrival));
    if (waiting.size() > input->capacity()) drop_oldest();
  }
  receiver->arrived_.notify_one();
}

/// Its number is kept: with several senders on a channel nobody could tell later whose gap it explains.
void Receiver::Queue::drop_oldest() {
  const std::vector<std::uint8_t>& oldest = waiting.front().bytes;
  if (const auto identity = input->identify(oldest.data(), oldest.size()))
    skipped.push_back(*identity);
  else
    ++unreadable;
  waiting.pop_front();
  ++count.drops;
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
  arrival.skipped = std::exchange(first->skipped, {});
  arrival.unreadable = std::exchange(first->unreadable, 0);
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

std::int64_t Receiver::refused() {
  const Refusals refusals = reader_->refusals();
  std::int64_t sum = refusals.foreign() + refusals.unsealed() + refusals.malformed();
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& queue : queues_) sum += queue->count.bad_parts;
  return sum;
}

std::vector<std::string> Receiver::stopped() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const SteadyTime now = std::chrono::steady_clock::now();
  std::vector<std::string> channels;
  for (const auto& queue : queues_)
    if (queue->input->admits && queue->pulse.stopped(now)) channels.push_back(queue->input->channel());
  return channels;
}

std::int64_t draw_sender() {
  std::random_device device;
  const std::uint64_t bits = (static_cast<std::uint64_t>(device()) << 32) ^ device();
  return static_cast<std::int64_t>((bits >> 1) | 1);
}

}  // namespace lcmslam

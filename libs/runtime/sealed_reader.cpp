#include <lcmslam/runtime/sealed_reader.hpp>

#include <lcmslam/log/seal_trailer.hpp>

namespace lcmslam {

SealedReader::SealedReader(std::unique_ptr<BusReader> source, const std::optional<BusKey>& key)
    : source_(std::move(source)) {
  if (key) checker_.emplace(*key);
}

bool SealedReader::read(BusMessage& message, std::chrono::milliseconds wait) {
  const auto end = std::chrono::steady_clock::now() + wait;
  while (true) {
    if (!source_->read(message, wait)) return false;
    if (takes(message)) return true;
    wait = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (wait.count() <= 0) return false;  // a flood of strangers must not keep the caller for ever
  }
}

bool SealedReader::takes(BusMessage& message) {
  if (!checker_) {
    message.bytes.resize(seal::size_within(message.bytes.data(), message.bytes.size()));
    return true;
  }
  const auto why = checker_->open(message, std::chrono::system_clock::now());
  if (!why) return true;
  const std::lock_guard<std::mutex> lock(mutex_);
  ++refused_.counts[static_cast<std::size_t>(*why)];
  refused_.last_unsealed = message.channel;
  refused_.last_age = checker_->last_age();
  return false;
}

Refusals SealedReader::refusals() const {
  Refusals refusals = source_->refusals();
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t kind = 0; kind < refusal_kinds; ++kind) refusals.counts[kind] += refused_.counts[kind];
  refusals.last_unsealed = refused_.last_unsealed;
  refusals.last_age = refused_.last_age;
  return refusals;
}

}  // namespace lcmslam

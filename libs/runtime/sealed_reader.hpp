#pragma once
// Between a bus and who reads it: takes seals off. With the bus's key only what is sealed by it passes.

#include <memory>
#include <mutex>

#include <lcmslam/runtime/bus_reader.hpp>
#include <lcmslam/runtime/seal.hpp>

namespace lcmslam {

class SealedReader : public BusReader {
 public:
  SealedReader(std::unique_ptr<BusReader> source, const std::optional<BusKey>& key);

  bool read(BusMessage& message, std::chrono::milliseconds wait) override;
  Refusals refusals() const override;
  SocketState socket() const override { return source_->socket(); }

 private:
  bool takes(BusMessage& message);

  std::unique_ptr<BusReader> source_;
  std::optional<SealChecker> checker_;
  mutable std::mutex mutex_;  // for what follows
  Refusals refused_;
};

}  // namespace lcmslam

#pragma once
// The live bus of `lcmslam log play`.

#include <map>

#include <lcmslam/runtime/lcm_bus.hpp>
#include "tools/log/log_player.hpp"

namespace lcmslam {

class LcmPlayBus : public PlayBus {
 public:
  /// Hears STATUS and the answer channels. Throws std::runtime_error when LCM cannot use the URL.
  LcmPlayBus(const std::string& lcm_url, const std::set<std::string>& answer_channels);

  Time now() override { return std::chrono::steady_clock::now(); }
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override;
  void wait_until(Time time) override;
  bool stopped() override;

  /// Processes that report that they run.
  const std::set<std::string>& running() const { return running_; }
  /// Processes that are there, whether they run yet or not.
  const std::set<std::string>& present() const { return present_; }
  /// Listens until all of these run, or the time is over; true when they do.
  bool wait_for(const std::set<std::string>& processes, Time until);

  std::int64_t split() const { return sender_.split(); }

 private:
  void receive_status(const BusMessage& message);

  LcmBus bus_;
  BusSender sender_;
  std::set<std::string> answer_channels_;
  std::unique_ptr<BusReader> reader_;
  std::set<std::string> running_, present_;
};

}  // namespace lcmslam

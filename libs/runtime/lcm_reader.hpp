#pragma once
// Reads through LCM: memq, tcpq and file, whose bytes come from nobody but their own end.

#include <deque>
#include <lcm/lcm-cpp.hpp>

#include <lcmslam/runtime/bus_reader.hpp>

namespace lcmslam {

class LcmReader : public BusReader {
 public:
  /// Throws std::runtime_error when LCM does not take the channels.
  LcmReader(lcm::LCM& lcm, const ChannelSet& channels);
  ~LcmReader() override;
  LcmReader(const LcmReader&) = delete;
  LcmReader& operator=(const LcmReader&) = delete;

  bool read(BusMessage& message, std::chrono::milliseconds wait) override;

 private:
  static void receive(const lcm_recv_buf_t* buffer, const char* channel, void* self);
  void unsubscribe();

  lcm_t* lcm_;
  std::vector<lcm_subscription_t*> subscriptions_;
  std::deque<BusMessage> waiting_;
};

}  // namespace lcmslam

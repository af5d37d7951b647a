#include <lcmslam/runtime/bus.hpp>

#include <stdexcept>

#include <lcmslam/runtime/lcm_reader.hpp>
#include <lcmslam/runtime/udpm/udpm_reader.hpp>

namespace lcmslam {
namespace {

bool is_udpm(const std::string& url) {
  return url.rfind("udpm:", 0) == 0;
}

}  // namespace

LcmBus::LcmBus(const std::string& lcm_url) : url_(lcm_url), lcm_(lcm_url) {
  if (lcm_url.rfind("mpudpm:", 0) == 0)
    throw std::invalid_argument(lcm_url + ": LCM's own reader of multicast is not safe; take udpm://");
  multicast_address(lcm_url);
  udpm::allowed_networks();
}

bool LcmBus::usable() {
  return lcm_.good() && (is_udpm(url_) || lcm_.getFileno() >= 0);
}

std::unique_ptr<BusReader> LcmBus::listen(const ChannelSet& channels) {
  if (!is_udpm(url_)) return std::make_unique<LcmReader>(lcm_, channels);
  const MulticastAddress address = multicast_address(url_);
  return std::make_unique<udpm::UdpmReader>(address, channels,
                                            udpm::SourceFilter(address.ttl, udpm::allowed_networks()));
}

}  // namespace lcmslam

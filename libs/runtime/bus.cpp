#include <lcmslam/runtime/bus.hpp>

#include <fcntl.h>
#include <unistd.h>
#include <stdexcept>

#include <lcmslam/runtime/bus_key.hpp>
#include <lcmslam/runtime/bus_robot.hpp>
#include <lcmslam/runtime/lcm_reader.hpp>
#include <lcmslam/runtime/sealed_reader.hpp>
#include <lcmslam/runtime/udpm/udpm_reader.hpp>

namespace lcmslam {
namespace {

bool is_udpm(const std::string& url) {
  return url.rfind("udpm:", 0) == 0;
}

/// LCM prints what fails while it opens a bus; whoever asked for the bus says that better.
class QuietErrors {
 public:
  QuietErrors() : kept_(dup(STDERR_FILENO)) {
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (kept_ >= 0 && nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    if (nowhere >= 0) close(nowhere);
  }
  ~QuietErrors() {
    if (kept_ < 0) return;
    dup2(kept_, STDERR_FILENO);
    close(kept_);
  }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  int kept_;
};

/// Throws std::invalid_argument for what LCM would only print.
const std::string& checked(const std::string& url) {
  for (const char* provider : {"udpm://", "memq://", "tcpq://", "file://"})
    if (url.rfind(provider, 0) == 0) return url;
  if (url.rfind("mpudpm:", 0) == 0)
    throw std::invalid_argument(url + ": LCM's own reader of multicast is not safe; take udpm://");
  throw std::invalid_argument(url +
                              ": is no bus; one begins with udpm://, memq://, tcpq:// or file://, such as "
                              "udpm://239.255.76.67:7667?ttl=0");
}

/// So that a temporary of the one is there while LCM's constructor runs.
const std::string& quietly(const std::string& url, const QuietErrors&) {
  return url;
}

}  // namespace

LcmBus::LcmBus(const std::string& lcm_url) : url_(checked(lcm_url)), lcm_(quietly(lcm_url, QuietErrors())) {
  multicast_address(lcm_url);
  udpm::allowed_networks();
  udpm::reassembly_limits();
  bus_key();
  robot_prefix();
}

bool LcmBus::usable() {
  return lcm_.good() && (is_udpm(url_) || lcm_.getFileno() >= 0);
}

std::unique_ptr<BusReader> LcmBus::listen(const ChannelSet& channels) {
  const std::string robot = robot_prefix();
  const ChannelSet wanted = robot.empty() ? channels : channels.below(robot);
  std::unique_ptr<BusReader> reader;
  if (is_udpm(url_)) {
    const MulticastAddress address = multicast_address(url_);
    udpm::SourceFilter filter(address.ttl, udpm::allowed_networks());
    reader = std::make_unique<udpm::UdpmReader>(address, wanted, std::move(filter));
  } else {
    reader = std::make_unique<LcmReader>(lcm_, wanted);
  }
  reader =
      std::make_unique<SealedReader>(std::move(reader), bus_key());  // a seal covers the robot's name too
  if (robot.empty()) return reader;
  return std::make_unique<RobotReader>(std::move(reader), robot);
}

}  // namespace lcmslam

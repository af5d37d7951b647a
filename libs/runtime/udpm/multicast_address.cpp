#include <lcmslam/runtime/udpm/multicast_address.hpp>

#include <arpa/inet.h>
#include <algorithm>
#include <stdexcept>

namespace lcmslam {
namespace {

/// Value of "key=" among the URL's options; 0 when it is not there.
std::int64_t option(const std::string& options, const std::string& key) {
  for (std::size_t at = 0; at < options.size(); at = std::min(options.find('&', at), options.size() - 1) + 1)
    if (options.compare(at, key.size(), key) == 0) return std::stoll(options.substr(at + key.size()));
  return 0;
}

}  // namespace

MulticastAddress multicast_address(const std::string& lcm_url) {
  const std::string scheme = "udpm://";
  if (lcm_url.rfind(scheme, 0) != 0) return {};
  MulticastAddress address;
  const std::size_t question = std::min(lcm_url.find('?'), lcm_url.size());
  const std::string place = lcm_url.substr(scheme.size(), question - scheme.size());
  const std::string options = lcm_url.substr(std::min(question + 1, lcm_url.size()));
  const std::size_t colon = place.find(':');
  address.group = place.substr(0, colon);
  try {
    if (colon != std::string::npos) address.port = std::stoi(place.substr(colon + 1));
    address.ttl = static_cast<int>(option(options, "ttl="));
    address.receive_buffer = option(options, "recv_buf_size=");
  } catch (const std::exception&) {
    address.port = 0;
  }
  in_addr parsed{};
  const bool is_address = inet_pton(AF_INET, address.group.c_str(), &parsed) == 1;
  const std::uint32_t group = ntohl(parsed.s_addr);
  // 224.0.0.0/24 is for routers; there the kernel takes packets even of no source.
  const bool is_group = is_address && (group >> 28) == 14 && (group >> 8) != 0xe00000;
  if (!is_group || address.port < 1 || address.port > 65535)
    throw std::invalid_argument(lcm_url +
                                ": must be udpm://GROUP:PORT with a multicast group (224.0.1.0 to "
                                "239.255.255.255), e.g. udpm://239.255.76.67:7667?ttl=0");
  return address;
}

}  // namespace lcmslam

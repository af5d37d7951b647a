#include <lcmslam/runtime/udpm/source_filter.hpp>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace lcmslam::udpm {
namespace {

constexpr std::chrono::seconds shortest_look{1};

Network parse_network(const std::string& text) {
  const std::size_t slash = text.find('/');
  in_addr address{};
  std::size_t used = 0;
  int bits = 32;
  try {
    if (slash != std::string::npos) bits = std::stoi(text.substr(slash + 1), &used);
  } catch (const std::exception&) {
    bits = -1;
  }
  const bool all_used = slash == std::string::npos || slash + 1 + used == text.size();
  if (inet_pton(AF_INET, text.substr(0, slash).c_str(), &address) != 1 || bits < 0 || bits > 32 || !all_used)
    throw std::invalid_argument("LCMSLAM_BUS_ALLOW: '" + text +
                                "' is neither an address (10.0.0.5) nor a network (10.0.1.0/24)");
  return {ntohl(address.s_addr), bits == 0 ? 0 : ~std::uint32_t{0} << (32 - bits)};
}

}  // namespace

std::vector<Network> parse_networks(const std::string& text) {
  std::string words = text;
  std::replace(words.begin(), words.end(), ',', ' ');
  std::istringstream in(words);
  std::vector<Network> networks;
  for (std::string word; in >> word;) networks.push_back(parse_network(word));
  return networks;
}

std::vector<Network> allowed_networks() {
  const char* text = std::getenv("LCMSLAM_BUS_ALLOW");
  return parse_networks(text != nullptr ? text : "");
}

std::vector<std::uint32_t> addresses_of_this_machine() {
  // Where lo is the only interface, multicast leaves with 0.0.0.0. From a wire the kernel takes no such
  // source.
  std::vector<std::uint32_t> addresses = {0};
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return addresses;
  for (const ifaddrs* i = first; i != nullptr; i = i->ifa_next)
    if (i->ifa_addr != nullptr && i->ifa_addr->sa_family == AF_INET)
      addresses.push_back(ntohl(reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr.s_addr));
  freeifaddrs(first);
  return addresses;
}

bool SourceFilter::takes(std::uint32_t address, Time now) {
  const auto is_own = [&] { return std::find(own_.begin(), own_.end(), address) != own_.end(); };
  if (everybody_ || is_own()) return true;
  for (const Network& network : allowed_)
    if (network.holds(address)) return true;
  if (looked_ != Time{} && now - looked_ < shortest_look) return false;
  looked_ = now;
  own_ = own_addresses_();
  return is_own();
}

}  // namespace lcmslam::udpm

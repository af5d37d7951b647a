#include "tools/doctor/checks.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/terminal_colours.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>

namespace lcmslam {
namespace {

using Level = Finding::Level;

constexpr std::int64_t enough_buffer = 4'194'304;  // bytes, for rmem_max: several images at once

/// Throws std::system_error when nothing can be sent to the group.
void try_route(const MulticastAddress& address) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(address.port));
  inet_pton(AF_INET, address.group.c_str(), &to.sin_addr);
  const bool routed = fd >= 0 && connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  const int error = errno;
  if (fd >= 0) close(fd);
  if (!routed) throw std::system_error(error, std::generic_category());
}

/// Interface of the narrowest route to the group, by the kernel's table (columns: interface, destination,
/// ..., the eighth is the mask).
std::string interface_to(const std::string& group) {
  in_addr address{};
  inet_pton(AF_INET, group.c_str(), &address);
  std::ifstream table("/proc/net/route");
  std::string line, best = "an unknown interface";
  std::int64_t narrowest = -1;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::istringstream columns(line);
    std::vector<std::string> words;
    for (std::string word; columns >> word;) words.push_back(word);
    if (words.size() < 8) continue;
    const auto destination = static_cast<std::uint32_t>(std::stoul(words[1], nullptr, 16));
    const auto mask = static_cast<std::uint32_t>(std::stoul(words[7], nullptr, 16));
    if ((address.s_addr & mask) != destination || static_cast<std::int64_t>(ntohl(mask)) <= narrowest)
      continue;
    narrowest = ntohl(mask);
    best = words[0];
  }
  return best;
}

std::string megabytes(double bytes) {
  return fmt::format("{:.1f} MB", bytes / 1e6);
}

}  // namespace

Finding check_route(const std::string& lcm_url, const std::string& wanted) {
  Finding finding{Level::good, "multicast route", "", ""};
  const MulticastAddress address = multicast_address(lcm_url);
  if (address.group.empty()) {
    finding.text = lcm_url + " needs none";
    return finding;
  }
  try {
    try_route(address);
    const std::string interface = interface_to(address.group);
    finding.text = fmt::format("packets to {} leave through {}", address.group, interface);
    if (!wanted.empty() && interface != wanted) {
      finding.level = Level::failure;
      finding.text += fmt::format(", but are meant to leave through {} (launch.interface)", wanted);
      finding.cure = fmt::format("sudo ip route replace {}/32 dev {}", address.group, wanted);
    } else if (interface == "lo" && address.ttl > 0) {
      finding.level = Level::warning;
      finding.text +=
          fmt::format(": with ttl={} other machines are meant to hear them, but do not", address.ttl);
      finding.cure = "sudo ip route replace 224.0.0.0/4 dev NETWORK_CARD";
    }
  } catch (const std::system_error& error) {
    finding.level = Level::failure;
    finding.text = fmt::format("there is none to {} ({}): nothing can be sent. Without root: --private-bus",
                               address.group, std::strerror(error.code().value()));
    finding.cure = "sudo ip route add 224.0.0.0/4 dev lo";
  }
  return finding;
}

Finding check_receive_buffer(const std::string& lcm_url, const GraphTraffic& traffic) {
  Finding finding{Level::good, "receive buffer", "", ""};
  const std::size_t whole = largest_whole_message(lcm_url);
  const std::size_t largest = traffic.largest;
  if (whole >= largest) {
    finding.text =
        fmt::format("holds the largest messages ({} kB, {}) whole", largest / 1000, traffic.origin);
    return finding;
  }
  finding.level = Level::note;
  finding.text = fmt::format(
      "messages above {} kB (here up to {} kB, {}) go in pieces; nothing is lost by that, but stock LCM "
      "tools see the pieces",
      std::max<std::size_t>(whole, 60'000) / 1000, largest / 1000, traffic.origin);
  finding.cure = fmt::format("sudo sysctl -w net.core.rmem_max={}", enough_buffer);
  if (lcm_url.find("recv_buf_size=") == std::string::npos)
    finding.text += "; the URL asks for no buffer, add recv_buf_size=2097152";
  return finding;
}

Finding check_governor(const std::filesystem::path& root) {
  Finding finding{Level::good, "CPU governor", "the kernel keeps the clock up by itself", ""};
  std::error_code error;
  for (const auto& cpu : std::filesystem::directory_iterator(root / "sys/devices/system/cpu", error)) {
    std::ifstream file(cpu.path() / "cpufreq/scaling_governor");
    std::string governor;
    if (!(file >> governor)) continue;
    finding.text = governor;
    if (governor != "powersave") continue;
    finding.level = Level::note;
    finding.text = "powersave: latencies grow while the clock is low";
    finding.cure = "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
    break;
  }
  return finding;
}

Finding check_disk(const std::filesystem::path& folder) {
  constexpr double low = 5e9, full = 5e8;  // bytes: a quarter of an hour and a minute of VGA images
  Finding finding{Level::good, "disk space", "", ""};
  struct statvfs state {};
  if (statvfs(folder.c_str(), &state) != 0) {
    finding.level = Level::failure;
    finding.text = folder.string() + ": " + std::strerror(errno);
    return finding;
  }
  const double free = static_cast<double>(state.f_bavail) * static_cast<double>(state.f_frsize);
  finding.text = fmt::format("{} free for maps and logs in {}", megabytes(free),
                             std::filesystem::absolute(folder).lexically_normal().string());
  if (free < low) finding.level = free < full ? Level::failure : Level::warning;
  if (access(folder.c_str(), W_OK) != 0) {
    finding.level = Level::failure;
    finding.text = std::filesystem::absolute(folder).string() + " cannot be written";
  }
  return finding;
}

std::vector<Finding> check_images(const GraphTraffic& traffic) {
  std::vector<Finding> findings;
  for (const std::string& doubt : traffic.doubts)
    findings.push_back({Level::warning, "images", "looks wrong: " + doubt, ""});
  if (findings.empty() && !traffic.depths.empty())
    findings.push_back({Level::good, "images", traffic.depths, ""});
  return findings;
}

std::vector<Finding> examine(const DoctorOptions& options) {
  std::vector<Finding> findings{check_route(options.lcm_url, options.interface)};
  if (findings.back().level != Level::failure) {
    findings.push_back(check_receive_buffer(options.lcm_url, options.traffic));
    findings.push_back(check_loop_back(options));
    findings.push_back(check_sources(options.lcm_url));
    for (const Finding& finding : check_traffic(options)) findings.push_back(finding);
  }
  for (const Finding& finding : check_images(options.traffic)) findings.push_back(finding);
  findings.push_back(check_governor());
  findings.push_back(check_disk(options.folder));
  return findings;
}

Finding::Level worst(const std::vector<Finding>& findings) {
  Level level = Level::good;
  for (const Finding& finding : findings) level = std::max(level, finding.level);
  return level;
}

std::string format_findings(const std::vector<Finding>& findings, bool all, bool colours) {
  static const char* const names[] = {"ok     ", "note   ", "warning", "FAILURE"};
  std::string text;
  for (const Finding& finding : findings) {
    if (!all && finding.level == Level::good) continue;
    const Emphasis emphasis = finding.level == Level::failure   ? Emphasis::failure
                              : finding.level == Level::warning ? Emphasis::warning
                                                                : Emphasis::good;
    text += fmt::format("  {}  {}: {}\n",
                        emphasised(names[static_cast<std::size_t>(finding.level)], emphasis, colours),
                        finding.subject, finding.text);
    if (!finding.cure.empty()) text += "           " + finding.cure + "\n";
  }
  return text;
}

}  // namespace lcmslam

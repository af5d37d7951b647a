#include <lcmslam/runtime/udpm/udpm_reader.hpp>

#include <arpa/inet.h>
#include <linux/sock_diag.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace lcmslam::udpm {
namespace {

using Clock = std::chrono::steady_clock;

void set_option(int socket, int level, int name, const void* value, std::size_t size) {
  if (setsockopt(socket, level, name, value, static_cast<socklen_t>(size)) != 0)
    throw std::system_error(errno, std::generic_category());
}

std::string name_of(const Source& source) {
  char text[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &source.address, text, sizeof text);
  return std::string(text) + ":" + std::to_string(ntohs(source.port));
}

std::uint32_t parse_group(const std::string& group) {
  in_addr address{};
  inet_pton(AF_INET, group.c_str(), &address);
  return address.s_addr;
}

}  // namespace

UdpmReader::UdpmReader(const MulticastAddress& address, ChannelSet channels, SourceFilter filter)
    : group_(parse_group(address.group)),
      channels_(std::move(channels)),
      filter_(std::move(filter)),
      reassembly_([this](const std::string& channel) { return channels_.holds(channel); },
                  reassembly_limits()),
      buffer_(largest_datagram) {
  reassembly_.on_refusal = [this](Refusal why) { count(why); };
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  try {
    open(address);
  } catch (const std::system_error& error) {
    if (socket_ >= 0) close(socket_);
    throw std::runtime_error("cannot listen to " + address.group + ":" + std::to_string(address.port) + ": " +
                             error.code().message());
  }
}

UdpmReader::~UdpmReader() {
  close(socket_);
}

/// As LCM's own sockets are, so that both hear the same bus; but only of the group that was joined here, and
/// with each packet's destination.
void UdpmReader::open(const MulticastAddress& address) {
  const int yes = 1, no = 0;
  const int buffer = static_cast<int>(std::min<std::int64_t>(address.receive_buffer, 1 << 30));
  set_option(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  set_option(socket_, SOL_SOCKET, SO_REUSEPORT, &yes, sizeof yes);
  if (buffer > 0) set_option(socket_, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
  set_option(socket_, IPPROTO_IP, IP_PKTINFO, &yes, sizeof yes);
  set_option(socket_, IPPROTO_IP, IP_MULTICAST_ALL, &no, sizeof no);

  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(address.port));
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0)
    throw std::system_error(errno, std::generic_category());
  if (!change_membership(IP_ADD_MEMBERSHIP)) throw std::system_error(errno, std::generic_category());
}

/// On the network card that the group's route leads to.
bool UdpmReader::change_membership(int option) const {
  ip_mreq membership{};
  membership.imr_multiaddr.s_addr = group_;
  return setsockopt(socket_, IPPROTO_IP, option, &membership, sizeof membership) == 0;
}

/// A card that went took the membership along, and senders follow the route by themselves. Who is a member is
/// refused with EADDRINUSE.
void UdpmReader::join_again() {
  if (change_membership(IP_ADD_MEMBERSHIP) || errno != ENOBUFS) return;
  change_membership(IP_DROP_MEMBERSHIP);  // those of cards that went count, too
  change_membership(IP_ADD_MEMBERSHIP);
}

bool UdpmReader::read(BusMessage& message, std::chrono::milliseconds wait) {
  const Clock::time_point now = Clock::now(), end = now + wait;
  if (now >= next_join_) {
    join_again();
    next_join_ = now + std::chrono::seconds(1);
  }
  while (true) {
    Datagram datagram;
    if (receive(datagram)) {
      if (auto whole = take(datagram)) {
        message = std::move(*whole);
        return true;
      }
      if (Clock::now() < end) continue;  // a flood of refused packets must not keep the caller for ever
      return false;
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd ready{socket_, POLLIN, 0};
    if (left <= 0 || poll(&ready, 1, static_cast<int>(left)) <= 0) return false;  // or a signal came
  }
}

/// False when none waits.
bool UdpmReader::receive(Datagram& datagram) {
  sockaddr_in from{};
  iovec place{buffer_.data(), buffer_.size()};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(in_pktinfo))];
  msghdr header{};
  header.msg_name = &from;
  header.msg_namelen = sizeof from;
  header.msg_iov = &place;
  header.msg_iovlen = 1;
  header.msg_control = control;
  header.msg_controllen = sizeof control;
  const ssize_t size = recvmsg(socket_, &header, MSG_DONTWAIT);
  if (size < 0) {
    if (errno == EAGAIN || errno == EINTR) return false;
    throw std::runtime_error(std::string("the bus cannot be read: ") + std::strerror(errno));
  }
  datagram.size = static_cast<std::size_t>(size);
  datagram.source = {from.sin_addr.s_addr, from.sin_port};
  for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
    if (c->cmsg_level != IPPROTO_IP || c->cmsg_type != IP_PKTINFO) continue;
    in_pktinfo info{};
    std::memcpy(&info, CMSG_DATA(c), sizeof info);
    datagram.destination = info.ipi_addr.s_addr;
  }
  return true;
}

/// The message that this datagram completes.
std::optional<BusMessage> UdpmReader::take(const Datagram& datagram) {
  if (!filter_.takes(ntohl(datagram.source.address), Clock::now())) return refuse(Refusal::foreign, datagram);
  if (datagram.destination != group_) return refuse(Refusal::not_group, datagram);
  const auto parsed = parse_packet(buffer_.data(), datagram.size);
  if (const Refusal* why = std::get_if<Refusal>(&parsed)) return refuse(*why, datagram);
  const Packet& packet = std::get<Packet>(parsed);
  if (packet.count > 1) return reassembly_.add(datagram.source, packet);
  if (packet.size != packet.message_size) return refuse(Refusal::contradiction, datagram);
  BusMessage message{std::string(packet.channel), {}};
  if (!channels_.holds(message.channel)) return std::nullopt;
  message.bytes.assign(packet.data, packet.data + packet.size);
  return message;
}

std::optional<BusMessage> UdpmReader::refuse(Refusal why, const Datagram& datagram) {
  count(why);
  if (why != Refusal::foreign && why != Refusal::not_group) return std::nullopt;
  const std::lock_guard<std::mutex> lock(mutex_);
  refusals_.last_stranger = name_of(datagram.source);
  return std::nullopt;
}

void UdpmReader::count(Refusal why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++refusals_.counts[static_cast<std::size_t>(why)];
  if (why != Refusal::foreign && why != Refusal::not_group && why != Refusal::incomplete)
    refusals_.last_malformed = describe(why);
}

Refusals UdpmReader::refusals() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return refusals_;
}

/// The kernel's account of this socket alone: of all of this process's, those that send would count too.
SocketState UdpmReader::socket() const {
  SocketState state;
  int buffer = 0;
  socklen_t size = sizeof buffer;
  if (getsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &buffer, &size) == 0) state.receive_buffer = buffer;
  std::uint32_t memory[SK_MEMINFO_VARS] = {};
  size = sizeof memory;
  if (getsockopt(socket_, SOL_SOCKET, SO_MEMINFO, memory, &size) == 0)
    state.kernel_drops = memory[SK_MEMINFO_DROPS];
  return state;
}

}  // namespace lcmslam::udpm

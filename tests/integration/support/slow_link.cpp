#include "tests/integration/support/slow_link.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <chrono>
#include <deque>
#include <stdexcept>
#include <vector>

namespace lcmslam::integration {
namespace {

constexpr std::size_t packet = 1448;  // bytes
constexpr int buffer = 16 * 1024;     // bytes that the kernel holds beside the link

int open_socket() {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1, small = buffer;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);  // else the kernel's buffers hide the link
  return fd;
}

sockaddr_in local(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

int bound_port(int fd) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

std::chrono::steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
}

bool write_all(int fd, const std::vector<char>& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = send(fd, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace

SlowLink::SlowLink(int server_port, const LinkQuality& quality)
    : server_port_(server_port), quality_(quality) {
  listener_ = open_socket();
  const sockaddr_in address = local(0);
  if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener_, 8) != 0)
    throw std::runtime_error("the slow link cannot listen");
  port_ = bound_port(listener_);
  acceptor_ = std::thread([this] { accept_all(); });
}

SlowLink::~SlowLink() {
  stop_ = true;
  acceptor_.join();
  for (std::thread& thread : threads_) thread.join();
  close(listener_);
}

void SlowLink::accept_all() {
  while (!stop_) {
    pollfd ready{listener_, POLLIN, 0};
    if (poll(&ready, 1, 50) <= 0) continue;
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    const int server = open_socket();
    const sockaddr_in address = local(server_port_);
    if (connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      close(server);
      close(client);
      continue;
    }
    threads_.emplace_back([this, client, server] { forward(client, server); });
  }
}

void SlowLink::forward(int client, int server) {
  std::thread other([&] { back(client, server); });
  there(client, server, quality_.seed++);
  shutdown(client, SHUT_RDWR);
  shutdown(server, SHUT_RDWR);
  other.join();
  close(client);
  close(server);
}

SlowLink::Clock::time_point SlowLink::free() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return free_;
}

SlowLink::Clock::time_point SlowLink::take(std::size_t bytes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  free_ = std::max(free_, Clock::now()) + seconds(static_cast<double>(bytes) / quality_.rate);
  return free_;
}

void SlowLink::there(int client, int server, std::uint32_t seed) {
  struct Packet {
    Clock::time_point arrives;
    std::vector<char> bytes;
  };
  std::deque<Packet> under_way;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0, 1);
  Clock::time_point held = Clock::now();  // this connection, until a lost packet has been sent again
  bool open = true;
  while (!stop_ && (open || !under_way.empty())) {
    const auto now = Clock::now();
    if (!under_way.empty() && under_way.front().arrives <= now) {
      forwarded_ += static_cast<std::int64_t>(under_way.front().bytes.size());
      if (!write_all(server, under_way.front().bytes)) return;
      under_way.pop_front();
      continue;
    }
    const auto next = std::max(held, free());
    const bool takes = open && next <= now;
    auto wait = std::chrono::milliseconds(20);
    if (!takes && open) wait = std::chrono::ceil<std::chrono::milliseconds>(next - now);
    if (!under_way.empty())
      wait = std::min(wait, std::chrono::ceil<std::chrono::milliseconds>(under_way.front().arrives - now));
    if (!takes) {
      std::this_thread::sleep_for(std::min(wait, std::chrono::milliseconds(20)));
      continue;
    }
    pollfd ready{client, POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(wait.count())) <= 0) continue;
    std::vector<char> bytes(packet);
    const ssize_t n = recv(client, bytes.data(), bytes.size(), 0);
    if (n <= 0) {
      open = false;
      continue;
    }
    bytes.resize(static_cast<std::size_t>(n));
    held = take(bytes.size());
    while (draw(random) < quality_.loss) {  // sent again, and perhaps again
      held += seconds(quality_.delay);
      ++lost_;
    }
    under_way.push_back({held + seconds(quality_.delay), std::move(bytes)});
  }
}

void SlowLink::back(int client, int server) {
  std::vector<char> bytes(16'384);
  while (!stop_) {
    pollfd ready{server, POLLIN, 0};
    if (poll(&ready, 1, 50) <= 0) continue;
    const ssize_t n = recv(server, bytes.data(), bytes.size(), 0);
    if (n <= 0 || !write_all(client, {bytes.begin(), bytes.begin() + n})) break;
  }
  shutdown(client, SHUT_RDWR);
}

int free_port() {
  const int fd = open_socket();
  const sockaddr_in address = local(0);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("no port is free");
  const int port = bound_port(fd);
  close(fd);
  return port;
}

}  // namespace lcmslam::integration

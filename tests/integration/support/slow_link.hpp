#pragma once
// A bad radio link, as TCP sees it: a proxy that forwards the connections to a port over a way there, which
// has a rate that they share, and losses. What a lost packet costs a TCP connection is the time until it has
// been sent again, in which all behind it on this connection waits: one time round. (The kernel's netem is
// not on every machine; this is its effect on connections, not its packets.)

#include <atomic>
#include <chrono>
#include <list>
#include <mutex>
#include <random>
#include <thread>

namespace lcmslam::integration {

struct LinkQuality {
  double rate = 250'000;  ///< bytes a second, from the client to the server
  double delay = 0.2;     ///< s on that way; the other takes no time
  double loss = 0.05;     ///< share of the packets
  std::uint32_t seed = 1;
};

class SlowLink {
 public:
  /// Listens on a port of 127.0.0.1 and forwards to another one.
  SlowLink(int server_port, const LinkQuality& quality);
  ~SlowLink();
  SlowLink(const SlowLink&) = delete;
  SlowLink& operator=(const SlowLink&) = delete;

  int port() const { return port_; }
  std::int64_t forwarded() const { return forwarded_; }  ///< bytes to the server
  std::int64_t lost() const { return lost_; }            ///< packets that had to be sent again

 private:
  void accept_all();
  void forward(int client, int server);
  void there(int client, int server, std::uint32_t seed);
  void back(int client, int server);

  int server_port_, port_ = 0, listener_ = -1;
  LinkQuality quality_;
  using Clock = std::chrono::steady_clock;
  /// When the link is free, before and after it takes this.
  Clock::time_point free() const;
  Clock::time_point take(std::size_t bytes);

  mutable std::mutex mutex_;
  Clock::time_point free_ = Clock::now();
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> forwarded_{0}, lost_{0};
  std::list<std::thread> threads_;
  std::thread acceptor_;
};

/// A port of 127.0.0.1 that nobody listens to now.
int free_port();

}  // namespace lcmslam::integration

#pragma once
// Another machine on the same wire: a process in a network namespace of its own, joined to this one's by a
// pair of virtual network cards.

#include <sched.h>
#include <sys/wait.h>
#include <cstdlib>
#include <memory>

#include "tests/support/datagrams.hpp"

namespace lcmslam::testing {

class Neighbour {
 public:
  static constexpr const char* own_address = "10.76.67.1";  ///< this side's
  static constexpr const char* address = "10.76.67.2";      ///< the neighbour's

  /// Nothing where this machine does not permit it. To be called before threads start, by a process that has
  /// a network namespace of its own (own_bus.hpp); from then on its multicast goes over the wire.
  static std::unique_ptr<Neighbour> join() {
    std::unique_ptr<Neighbour> neighbour(new Neighbour);
    return neighbour->joined_ ? std::move(neighbour) : nullptr;
  }
  ~Neighbour() {
    close(request_[1]);
    waitpid(child_, nullptr, 0);
    close(answer_[0]);
  }
  Neighbour(const Neighbour&) = delete;
  Neighbour& operator=(const Neighbour&) = delete;

  /// Returns when it is on the wire. `to`: own_address, or a multicast group (which reaches the next
  /// machine).
  void send(const std::string& to, int port, const Bytes& bytes) {
    Request request{};
    to.copy(request.address, sizeof request.address - 1);
    request.port = port;
    request.size = bytes.size();
    char sent = 0;
    if (write(request_[1], &request, sizeof request) < 0 ||
        write(request_[1], bytes.data(), bytes.size()) < 0 || read(answer_[0], &sent, 1) != 1 || sent != 1)
      throw std::runtime_error("the neighbour cannot send to " + to);
  }

 private:
  struct Request {
    char address[16];
    int port;
    std::size_t size;
  };

  Neighbour() {
    if (pipe(request_) != 0 || pipe(answer_) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ == 0) {
      close(request_[1]);
      close(answer_[0]);
      live();
      _exit(0);
    }
    close(request_[0]);
    close(answer_[1]);
    char ready = 0;
    const std::string pid = std::to_string(child_), own = own_address;
    joined_ = read(answer_[0], &ready, 1) == 1 && ready == 1 &&
              run("ip link add wire0 type veth peer name wire1 netns " + pid) &&
              run("ip address add " + own + "/24 dev wire0 && ip link set wire0 up") &&
              run("ip route replace 224.0.0.0/4 dev wire0") && write(request_[1], "c", 1) == 1 &&
              read(answer_[0], &ready, 1) == 1 && ready == 1;
  }

  static bool run(const std::string& command) { return std::system((command + " 2>/dev/null").c_str()) == 0; }
  void answer(bool well) const {
    const char byte = well ? 1 : 0;
    if (write(answer_[1], &byte, 1) != 1) _exit(1);
  }

  /// The neighbour's own process.
  void live() const {
    answer(unshare(CLONE_NEWNET) == 0);
    char connect = 0;
    if (read(request_[0], &connect, 1) != 1) return;
    answer(run(std::string("ip address add ") + address +
               "/24 dev wire1 && ip link set wire1 up && ip route add 224.0.0.0/4 dev wire1"));
    const UdpSender sender(1);
    Request request{};
    while (read(request_[0], &request, sizeof request) == sizeof request) {
      Bytes bytes(request.size);
      for (std::size_t got = 0; got < bytes.size();) {
        const ssize_t n = read(request_[0], bytes.data() + got, bytes.size() - got);
        if (n <= 0) return;
        got += static_cast<std::size_t>(n);
      }
      try {
        sender.send(request.address, request.port, bytes);
        answer(true);
      } catch (const std::runtime_error&) {
        answer(false);
      }
    }
  }

  int request_[2] = {-1, -1}, answer_[2] = {-1, -1};
  pid_t child_ = 0;
  bool joined_ = false;
};

}  // namespace lcmslam::testing

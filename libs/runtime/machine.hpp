#pragma once
// What the operating system says of this process.

#include <cstdint>

namespace lcmslam {

/// Images come and go thirty times a second. By default glibc maps and unmaps each of them, and the
/// kernel's clearing of fresh pages costs a vision process a fifth of its time; so freed memory is kept.
void keep_freed_memory();

double process_cpu_seconds();
/// Of the calling thread.
double thread_cpu_seconds();
/// Of this process's first thread, so far; zero where the kernel does not count it.
struct ThreadTime {
  double ran = 0;     ///< s on a processor
  double waited = 0;  ///< s in which it could have run and had none
};
ThreadTime main_thread_time();
std::int64_t resident_bytes();

/// The calling thread, and those that it starts, stand back when another one of this machine's wakes up.
/// For the thread that computes: the one that empties the sockets must not wait for it.
void yield_to_receivers();

/// Of the UDP sockets that this process holds.
struct SocketState {
  std::int64_t kernel_drops = 0;    ///< datagrams dropped because a receive buffer was full
  std::int64_t receive_buffer = 0;  ///< bytes granted, of the largest; 0 without UDP
};
SocketState socket_state();

/// Receive buffer that the kernel grants a UDP socket that asks for `bytes` (0: does not ask), as the
/// kernel reports it: twice the grant.
std::int64_t granted_receive_buffer(std::int64_t bytes);

}  // namespace lcmslam

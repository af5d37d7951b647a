#pragma once
// SIGINT and SIGTERM ask a process to stop.

namespace lcmslam {

/// A process that has not stopped `watchdog` seconds after the signal is ended by the kernel (SIGALRM):
/// its supervisor may be dead. 0: never.
void install_stop_signals(unsigned watchdog);
bool stop_requested();
void request_stop();

}  // namespace lcmslam

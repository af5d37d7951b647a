#pragma once
// SIGINT, SIGTERM and SIGHUP (the terminal was closed) ask a process to stop.

namespace lcmslam {

/// Who was started with SIGHUP ignored (nohup) goes on without its terminal.
/// A process that has not stopped `watchdog` seconds after the signal is ended by the kernel (SIGALRM):
/// its supervisor may be dead. 0: never.
void install_stop_signals(unsigned watchdog);
bool stop_requested();
void request_stop();

}  // namespace lcmslam

#pragma once
// SIGINT and SIGTERM ask a process to stop; one that has not stopped 15 s later is ended by the kernel.

namespace lcmslam {

void install_stop_signals();
bool stop_requested();
void request_stop();

}  // namespace lcmslam

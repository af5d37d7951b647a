#pragma once

namespace lcmslam {

/// OpenCV's threads of a process that is one of several on this machine: a quarter of the processors, at
/// least one. Threads whose processors are busy with the other processes save no time, and those that wait
/// for them spin.
void share_processors();

}  // namespace lcmslam

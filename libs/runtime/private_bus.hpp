#pragma once
// A bus of one's own: a network namespace with a multicast route on its loop-back interface.

namespace lcmslam {

/// Moves this process (before it starts threads) and all that it starts into a new network namespace;
/// without root through a user namespace. False where the machine
/// forbids it; then the process may be left without any network and should end.
bool enter_private_bus();

}  // namespace lcmslam

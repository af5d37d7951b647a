#pragma once
// Jobs one after the other beside the messages, in a thread of their own.

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace lcmslam {

class JobThread {
 public:
  /// Without `background` each job is done by who hands it in. At most so many wait.
  JobThread(bool background, std::size_t most);
  /// Jobs that wait are not begun any more.
  ~JobThread();
  JobThread(const JobThread&) = delete;
  JobThread& operator=(const JobThread&) = delete;

  /// Where it is behind, the oldest goes but for the first, which loads what the others look into.
  void hand_in(std::function<void()> job);

 private:
  void work();

  std::size_t most_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> jobs_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace lcmslam

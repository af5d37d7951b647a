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
  /// Without `background` each job is done by who hands it in. So many may wait.
  JobThread(bool background, std::size_t most);
  /// Jobs that wait are not begun any more.
  ~JobThread();
  JobThread(const JobThread&) = delete;
  JobThread& operator=(const JobThread&) = delete;

  /// Each is done, in their order.
  void hand_in(std::function<void()> job);
  /// Where it is behind, the oldest of these goes.
  void hand_in_missable(std::function<void()> job);

 private:
  struct Job {
    std::function<void()> work;
    bool may_be_missed;
  };
  void hand_in(Job job);
  void work();

  std::size_t most_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Job> jobs_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace lcmslam

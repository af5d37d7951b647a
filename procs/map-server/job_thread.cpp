#include "procs/map-server/job_thread.hpp"

#include <algorithm>

namespace lcmslam {

JobThread::JobThread(bool background, std::size_t most) : most_(most) {
  if (background) thread_ = std::thread([this] { work(); });
}

JobThread::~JobThread() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void JobThread::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stop_ || !jobs_.empty(); });
    if (stop_) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job.work();
    lock.lock();
  }
}

void JobThread::hand_in(std::function<void()> job) {
  hand_in({std::move(job), false});
}

void JobThread::hand_in_missable(std::function<void()> job) {
  hand_in({std::move(job), true});
}

void JobThread::hand_in(Job job) {
  if (!thread_.joinable()) return job.work();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    jobs_.push_back(std::move(job));
    const auto oldest =
        std::find_if(jobs_.begin(), jobs_.end(), [](const Job& waiting) { return waiting.may_be_missed; });
    if (jobs_.size() > most_ && oldest != jobs_.end()) jobs_.erase(oldest);
  }
  wake_.notify_all();
}

}  // namespace lcmslam

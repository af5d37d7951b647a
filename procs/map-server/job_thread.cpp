#include "procs/map-server/job_thread.hpp"

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
    const auto job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job();
    lock.lock();
  }
}

void JobThread::hand_in(std::function<void()> job) {
  if (!thread_.joinable()) return job();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (jobs_.size() >= most_) jobs_.erase(jobs_.begin() + 1);
    jobs_.push_back(std::move(job));
  }
  wake_.notify_all();
}

}  // namespace lcmslam

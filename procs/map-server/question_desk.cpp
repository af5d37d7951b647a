#include "procs/map-server/question_desk.hpp"

#include <algorithm>
#include <utility>

namespace lcmslam {
namespace {

constexpr std::size_t most_waiting = 64;
constexpr std::ptrdiff_t most_clouds = 2;

QuestionDesk::Answered answered(const QuestionDesk::Asked& asked) {
  QuestionDesk::Answered result{
      asked.request, "", {}, asked.map.frame, asked.map.live ? asked.map.live->version() : 0};
  try {
    result.answer = answer(asked.question, asked.map);
  } catch (const std::exception& error) {
    result.error = error.what();
  }
  return result;
}

}  // namespace

QuestionDesk::QuestionDesk(bool background) {
  if (background) thread_ = std::thread([this] { work(); });
}

QuestionDesk::~QuestionDesk() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

bool QuestionDesk::has(const map_request_t& request) const {
  const auto same = [&](const map_request_t& r) {
    return r.sender == request.sender && r.request_id == request.request_id && r.argument == request.argument;
  };
  const std::lock_guard<std::mutex> lock(mutex_);
  return (working_ && same(*working_)) ||
         std::any_of(waiting_.begin(), waiting_.end(),
                     [&](const Waiting& w) { return same(w.asked.request); }) ||
         std::any_of(answered_.begin(), answered_.end(), [&](const Answered& a) { return same(a.request); });
}

bool QuestionDesk::is_full_for(const Question& question) const {
  const auto is_cloud = [](const Question& q) { return std::holds_alternative<CloudQuestion>(q.what); };
  const std::lock_guard<std::mutex> lock(mutex_);
  if (waiting_.size() >= most_waiting) return true;
  return is_cloud(question) && std::count_if(waiting_.begin(), waiting_.end(), [&](const Waiting& w) {
                                 return is_cloud(w.asked.question);
                               }) >= most_clouds;
}

bool QuestionDesk::ask(Asked asked) {
  const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(asked.question.deadline));
  const std::lock_guard<std::mutex> lock(mutex_);
  if (waiting_.size() >= most_waiting) return false;
  if (thread_.joinable())
    waiting_.push_back({std::move(asked), until});
  else
    answered_.push_back(answered(asked));
  wake_.notify_one();
  return true;
}

void QuestionDesk::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stop_ || !waiting_.empty(); });
    if (stop_) return;
    Waiting waiting = std::move(waiting_.front());
    waiting_.pop_front();
    working_ = waiting.asked.request;
    lock.unlock();
    Answered result{
        waiting.asked.request, "it came too late: its deadline was over before its turn", {}, "", 0};
    waiting.asked.map.is_late = [until = waiting.until] { return Clock::now() >= until; };
    if (!waiting.asked.map.is_late()) result = answered(waiting.asked);
    lock.lock();
    working_.reset();
    answered_.push_back(std::move(result));
  }
}

std::vector<QuestionDesk::Answered> QuestionDesk::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(answered_, {});
}

bool QuestionDesk::busy() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return working_.has_value() || !waiting_.empty() || !answered_.empty();
}

}  // namespace lcmslam

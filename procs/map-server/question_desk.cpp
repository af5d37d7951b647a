#include "procs/map-server/question_desk.hpp"

#include <algorithm>
#include <utility>

namespace lcmslam {
namespace {

constexpr std::size_t most_waiting = 64;
constexpr std::ptrdiff_t most_clouds = 2;

/// Its line's number. Distances and collisions cost milliseconds; clouds and meshes take seconds.
std::size_t line_of(const Question& question) {
  const auto& what = question.what;
  const bool is_of_space =
      std::holds_alternative<DistanceQuestion>(what) || std::holds_alternative<CollisionQuestion>(what) ||
      std::holds_alternative<PathQuestion>(what) || std::holds_alternative<SpaceQuestion>(what);
  return is_of_space ? 0 : 1;
}

QuestionDesk::Answered answered(const QuestionDesk::Asked& asked) {
  QuestionDesk::Answered result{asked.request,
                                "",
                                {},
                                asked.map.frame,
                                asked.map.changes + (asked.map.live ? asked.map.live->version() : 0)};
  try {
    result.answer = answer(asked.question, asked.map);
  } catch (const std::exception& error) {
    result.error = error.what();
  }
  return result;
}

}  // namespace

QuestionDesk::QuestionDesk(bool background) {
  if (!background) return;
  for (Line& line : lines_) line.thread = std::thread([this, &line] { work(line); });
}

QuestionDesk::~QuestionDesk() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  for (Line& line : lines_) {
    line.wake.notify_all();
    if (line.thread.joinable()) line.thread.join();
  }
}

bool QuestionDesk::has(const map_request_t& request) const {
  const auto same = [&](const map_request_t& r) {
    return r.sender == request.sender && r.request_id == request.request_id && r.argument == request.argument;
  };
  const auto is_in = [&](const Line& line) {
    return (line.working && same(*line.working)) ||
           std::any_of(line.waiting.begin(), line.waiting.end(),
                       [&](const Waiting& w) { return same(w.asked.request); });
  };
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::any_of(lines_.begin(), lines_.end(), is_in) ||
         std::any_of(answered_.begin(), answered_.end(), [&](const Answered& a) { return same(a.request); });
}

bool QuestionDesk::is_full_for(const Question& question) const {
  const auto is_cloud = [](const Question& q) { return std::holds_alternative<CloudQuestion>(q.what); };
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::deque<Waiting>& waiting = lines_[line_of(question)].waiting;
  if (waiting.size() >= most_waiting) return true;
  return is_cloud(question) && std::count_if(waiting.begin(), waiting.end(), [&](const Waiting& w) {
                                 return is_cloud(w.asked.question);
                               }) >= most_clouds;
}

bool QuestionDesk::ask(Asked asked) {
  const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(asked.question.deadline));
  const std::lock_guard<std::mutex> lock(mutex_);
  Line& line = lines_[line_of(asked.question)];
  if (line.waiting.size() >= most_waiting) return false;
  if (line.thread.joinable())
    line.waiting.push_back({std::move(asked), until});
  else
    answered_.push_back(answered(asked));
  line.wake.notify_one();
  return true;
}

void QuestionDesk::work(Line& line) {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    line.wake.wait(lock, [&] { return stop_ || !line.waiting.empty(); });
    if (stop_) return;
    Waiting waiting = std::move(line.waiting.front());
    line.waiting.pop_front();
    line.working = waiting.asked.request;
    lock.unlock();
    Answered result{
        waiting.asked.request, "it came too late: its deadline was over before its turn", {}, "", 0};
    waiting.asked.map.is_late = [until = waiting.until] { return Clock::now() >= until; };
    if (!waiting.asked.map.is_late()) result = answered(waiting.asked);
    lock.lock();
    line.working.reset();
    answered_.push_back(std::move(result));
  }
}

std::vector<QuestionDesk::Answered> QuestionDesk::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(answered_, {});
}

bool QuestionDesk::busy() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !answered_.empty() || std::any_of(lines_.begin(), lines_.end(), [](const Line& line) {
    return line.working.has_value() || !line.waiting.empty();
  });
}

}  // namespace lcmslam

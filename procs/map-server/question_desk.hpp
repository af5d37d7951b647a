#pragma once
// Answers questions in threads of its own: what takes long delays no message. Those of space alone, which a
// planner asks all the time, are answered one after the other, and all others beside them.

#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include <lcmslam/live_map/answer.hpp>
#include <lcmslam/map_request_t.hpp>

namespace lcmslam {

class QuestionDesk {
 public:
  /// With `background` false who asks answers it himself.
  explicit QuestionDesk(bool background);
  ~QuestionDesk();
  QuestionDesk(const QuestionDesk&) = delete;
  QuestionDesk& operator=(const QuestionDesk&) = delete;

  struct Asked {
    map_request_t request;  ///< of which the reply repeats what it must
    Question question;
    AskedMap map;
  };
  struct Answered {
    map_request_t request;
    std::string error;  ///< empty: there is an answer
    Answer answer;
    std::string frame;
    std::int64_t map_version = 0;
  };

  /// Whether that very request waits or its answer does: who asks again without one waits for the first.
  bool has(const map_request_t& request) const;
  /// Whether ask() would refuse it: too many wait, or too many that hold a copy of the map's points.
  bool is_full_for(const Question& question) const;
  /// False: too many wait.
  bool ask(Asked asked);
  /// What has been answered since.
  std::vector<Answered> take();
  /// Whether something will come of take().
  bool busy() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Waiting {
    Asked asked;
    Clock::time_point until;
  };
  struct Line {
    std::deque<Waiting> waiting;
    std::optional<map_request_t> working;  // on its question
    std::condition_variable wake;
    std::thread thread;
  };
  void work(Line& line);

  mutable std::mutex mutex_;   // guards what follows; not held while a question is answered
  std::array<Line, 2> lines_;  // of space, and of all else
  std::vector<Answered> answered_;
  bool stop_ = false;
};

}  // namespace lcmslam

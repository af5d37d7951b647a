#include <lcmslam/runtime/status_pace.hpp>

namespace lcmslam {
namespace {

constexpr std::chrono::seconds status_period{1};
constexpr std::chrono::milliseconds news_period{200};
constexpr std::chrono::milliseconds troubles_period{500};  // of a stranger who sends on and on

}  // namespace

bool StatusPace::due(const NodeReport& report, std::int64_t troubles, Time now) {
  const bool is_worse = troubles > troubles_;
  const bool says_else = report.detail != words_ && now >= next_words_;
  const bool is_due =
      report.state != state_ || says_else || (is_worse && now >= next_troubles_) || now >= next_;
  if (!is_due) return false;
  state_ = report.state;
  words_ = report.detail;
  troubles_ = troubles;
  next_ = now + status_period;
  next_words_ = now + news_period;
  next_troubles_ = now + (is_worse ? troubles_period : news_period);
  return true;
}

}  // namespace lcmslam

#include <lcmslam/runtime/status_pace.hpp>

namespace lcmslam {
namespace {

constexpr std::chrono::seconds status_period{1};
constexpr std::chrono::milliseconds news_period{200};
constexpr std::chrono::milliseconds refusals_period{500};  // of who sends on and on

}  // namespace

bool StatusPace::due(const NodeReport& report, std::int64_t refused, Time now) {
  const bool refuses = refused > refused_;
  const bool says_else = report.detail != words_ && now >= next_words_;
  const bool is_due =
      report.state != state_ || says_else || (refuses && now >= next_refused_) || now >= next_;
  if (!is_due) return false;
  state_ = report.state;
  words_ = report.detail;
  refused_ = refused;
  next_ = now + status_period;
  next_words_ = now + news_period;
  next_refused_ = now + (refuses ? refusals_period : news_period);
  return true;
}

}  // namespace lcmslam

#include <lcmslam/cameras/watched_camera.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lcmslam {
namespace {

constexpr std::chrono::milliseconds patience{100};
constexpr Utime stamps_began_anew = 1'000'000;  // us back

using Seconds = std::chrono::duration<double>;

std::string in_seconds(Seconds time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", std::max(time.count(), 0.0));
  return text;
}

}  // namespace

void WatchSettings::describe(SettingsVisitor& s) {
  s.number("late_after", late_after, "s", {0.01, 60},
           "without an image, after which STATUS says so; above the camera's interval");
  s.number("reopen_after", reopen_after, "s", {0.01, 600},
           "without an image, after which the camera is closed and opened again");
  s.number("retry_after", retry_after, "s", {0.01, 600},
           "until a camera that is gone is opened again; twice as long after each failure");
  s.number("retry_at_most", retry_at_most, "s", {0.01, 3600}, "of such a pause");
}

WatchedCamera::WatchedCamera(OpenCamera open, const ExpectedImages& expected, const WatchSettings& settings,
                             Clock clock)
    : open_(std::move(open)), expected_(expected), settings_(settings), clock_(std::move(clock)) {}

WatchedCamera::Step WatchedCamera::step() {
  if (!device_) {
    const auto wait = next_opening_ - clock_();
    if (wait > Time::duration{0}) return {std::nullopt, std::chrono::ceil<std::chrono::milliseconds>(wait)};
    open();
    if (!device_) return {};
  }
  Step step;
  try {
    if (auto frame = device_->read(patience))
      step.frame = check(std::move(*frame));
    else
      step.wait = std::chrono::milliseconds(1);  // should a driver not have waited
    if (!step.frame) close_if_silent();
  } catch (const std::exception& error) {
    close(error.what());
  }
  return step;
}

/// A camera that sends nothing good is no better than one that sends nothing.
void WatchedCamera::close_if_silent() {
  const Seconds since = clock_() - last_good_;
  if (device_->ended())
    close("it has ended");
  else if (since.count() > settings_.reopen_after)
    close("no image for " + in_seconds(since) + (misfit_.empty() ? "" : ": " + misfit_));
}

void WatchedCamera::open() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++health_.opening;
    opening_since_ = clock_();
  }
  std::string description;
  try {
    device_ = open_();
    description = device_->describe();  // asks the driver: nobody must wait for that
  } catch (const std::exception& error) {
    close(error.what());
    return;
  }
  gaps_.forget();  // while it was away nothing was left out
  const std::lock_guard<std::mutex> lock(mutex_);
  opening_since_.reset();
  health_.open = true;
  ++health_.opened;
  description_ = std::move(description);
  misfit_.clear();
  last_good_ = clock_();
}

void WatchedCamera::close(const std::string& why) {
  device_.reset();
  const std::lock_guard<std::mutex> lock(mutex_);
  opening_since_.reset();
  health_.open = false;
  why_closed_ = why;
  ++failures_;
  next_opening_ = clock_() + std::chrono::duration_cast<Time::duration>(pause());
}

/// Doubles with each failure in a row.
Seconds WatchedCamera::pause() const {
  const double doubled = settings_.retry_after * std::ldexp(1.0, std::min(failures_ - 1, 30));
  return Seconds(std::min(doubled, settings_.retry_at_most));
}

std::string WatchedCamera::what_is_wrong(const CameraShot& frame) const {
  std::string wrong = misfit(frame, expected_);
  const bool earlier = frame.utime <= last_utime_ && frame.utime > last_utime_ - stamps_began_anew;
  if (wrong.empty() && earlier) wrong = "an image's stamp is not later than the one's before";
  return wrong;
}

std::optional<CameraShot> WatchedCamera::check(CameraShot frame) {
  const std::string wrong = what_is_wrong(frame);
  const std::lock_guard<std::mutex> lock(mutex_);
  misfit_ = wrong;
  if (!wrong.empty()) {
    ++health_.refused;
    return std::nullopt;
  }
  last_utime_ = frame.utime;
  health_.dropped += gaps_.missing_before(frame.utime);
  ++health_.images;
  failures_ = 0;
  last_good_ = clock_();
  return frame;
}

CameraHealth WatchedCamera::health() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  CameraHealth health = health_;
  const Time now = clock_();
  const Seconds without = now - last_good_;
  health.silent = !health.open || without.count() > settings_.late_after;
  if (opening_since_) {
    const Seconds since = now - *opening_since_;
    if (since.count() > settings_.late_after) health.trouble = "is being opened for " + in_seconds(since);
  } else if (!health.open && health.opening > 0) {
    health.trouble = why_closed_ + "; is tried again in " + in_seconds(next_opening_ - now);
    if (failures_ > 1) health.trouble += " (failed " + std::to_string(failures_) + " times)";
  } else if (!misfit_.empty()) {
    health.trouble = misfit_;
  } else if (health.open && health.silent) {
    health.trouble = "no image for " + in_seconds(without);
  }
  return health;
}

std::string WatchedCamera::description() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return description_;
}

}  // namespace lcmslam

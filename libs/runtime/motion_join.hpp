#pragma once
// Joins measurements with odometry by utime: a measurement waits until odometry covers its time, or
// until message time has moved on too far; then it goes on without, and that is counted. Message time
// only, never the wall clock: batch and live decide alike.

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

template <class Measurement>
class MotionJoin {
 public:
  using Handler = std::function<void(Measurement&)>;

  /// `max_wait` in s of message time; at most `capacity` measurements wait, then the oldest is dropped.
  /// Visual odometry may go on for `extrapolation` s beyond its newest sample: a millisecond more would cost
  /// the wait for the next image.
  MotionJoin(double max_wait, std::size_t capacity, Handler handler, double extrapolation = 0)
      : max_wait_(static_cast<Utime>(1e6 * max_wait)),
        extrapolation_(static_cast<Utime>(1e6 * extrapolation)),
        capacity_(capacity),
        handler_(std::move(handler)) {}

  const MotionBuffer& motion() const { return motion_; }
  std::int64_t sender() const { return sender_; }  ///< of motion()
  std::optional<Motion> between(Utime from, Utime to) const { return motion_.between(from, to, beyond()); }

  /// Something else that a measurement needs: it waits for that as well, up to `max_wait` s of message time
  /// by itself, then goes on without, and that is counted. Whoever sees it come calls look().
  void need(std::function<bool(const Measurement&)> is_there, double max_wait) {
    is_there_ = std::move(is_there);
    max_other_wait_ = static_cast<Utime>(1e6 * max_wait);
  }
  void look() {
    if (now_) release(false);
  }

  /// `needed` is the latest time that odometry must cover.
  void add(Utime needed, Measurement measurement) {
    advance(needed);
    waiting_.emplace_back(needed, std::move(measurement));
    while (waiting_.size() > capacity_) {
      waiting_.pop_front();
      ++dropped_;
    }
    release(false);
  }

  /// `sender` of odometry: another one's path begins elsewhere, so that the two do not compare. A sample
  /// that comes twice or late is left out.
  void add(const MotionSample& sample, std::int64_t sender = 0) {
    if (sender != sender_) motion_ = MotionBuffer(history);
    sender_ = sender;
    visual_ = sample.visual;
    if (!motion_.empty() && sample.utime <= motion_.newest()) return;
    motion_.add(sample);
    advance(sample.utime);
    release(false);
  }

  /// Time begins anew: what waits goes on as it is, and nothing is known of the motion.
  void begin_session() {
    flush();
    motion_ = MotionBuffer(history);
    now_.reset();
  }

  /// Everything that waits goes on as it is.
  void flush() { release(true); }

  std::int64_t without_odometry() const { return without_odometry_; }
  std::int64_t without_other() const { return without_other_; }
  std::int64_t dropped() const { return dropped_; }

 private:
  static constexpr Utime history = 120'000'000;  // us: a camera may be away so long, and its motion is known

  Utime beyond() const { return visual_ ? extrapolation_ : 0; }
  void advance(Utime utime) { now_ = std::max(now_.value_or(utime), utime); }

  void release(bool all) {
    while (!waiting_.empty()) {
      const Utime needed = waiting_.front().first;
      const bool covered = !motion_.empty() && motion_.newest() + beyond() >= needed;
      const bool complete = !is_there_ || is_there_(waiting_.front().second);
      if (!covered && !all && *now_ - needed <= max_wait_) return;
      if (!complete && !all && *now_ - needed <= max_other_wait_) return;
      if (!covered) ++without_odometry_;
      if (!complete) ++without_other_;
      Measurement measurement = std::move(waiting_.front().second);
      waiting_.pop_front();
      handler_(measurement);
    }
  }

  Utime max_wait_;
  Utime extrapolation_;
  std::size_t capacity_;
  Handler handler_;
  MotionBuffer motion_{history};
  std::int64_t sender_ = 0;  // of odometry
  bool visual_ = false;
  std::deque<std::pair<Utime, Measurement>> waiting_;
  std::optional<Utime> now_;  // the newest time
  std::int64_t without_odometry_ = 0;
  std::function<bool(const Measurement&)> is_there_;  // of what need() names
  Utime max_other_wait_ = 0;
  std::int64_t without_other_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace lcmslam

#pragma once
// What a link to a browser bears, by what it acknowledges: the rate at which bytes are delivered and the
// shortest way there and back (after Cardwell et al., "BBR: Congestion-Based Congestion Control", 2016).
// A sender that keeps no more under way than the rate times that way and a little delay never builds up a
// queue of old pictures.

#include <cstdint>
#include <deque>

namespace lcmslam {

class LinkRate {
 public:
  /// So many bytes went out. `now` s.
  void sent(std::uint64_t bytes, double now);
  /// So many bytes have arrived in all; more than were sent count as those, fewer than before as nothing.
  void acknowledged(std::uint64_t total, double now);

  std::uint64_t under_way() const { return sent_ - delivered_; }
  /// Bytes that may be under way for them to wait in line for `delay` s at most.
  double window(double delay) const;
  /// s for which what has gone out waits in line, as far as the rate tells.
  double line(double now) const;
  /// True for a moment once in a while: bulk is to wait then, so that the way without a queue is seen again.
  bool is_probing(double now);
  /// s since anything was acknowledged while something was under way; 0 when nothing is.
  double silence(double now) const { return under_way() > 0 ? now - heard_ : 0; }
  double rate() const { return rate_; }              ///< bytes a second
  double round_trip() const { return round_trip_; }  ///< s

 private:
  struct Flight {
    std::uint64_t end;  // sent_ after it
    double sent;
    std::uint64_t delivered;  // when it went out
    double delivered_at;
  };
  struct Sample {
    double at, value;
  };
  static constexpr double slowest = 64'000;   // bytes a second: as long as nothing is known
  static constexpr double smallest = 16'000;  // bytes of a window
  static constexpr double remembered = 5;     // s, of rates
  static constexpr double believed = 10;      // s, of the way
  static constexpr double probe = 0.6;        // s
  static constexpr double negligible = 0.02;  // s of a way

  std::deque<Flight> flights_;
  std::deque<Sample> rates_;
  std::uint64_t sent_ = 0, delivered_ = 0;
  double delivered_at_ = 0, heard_ = 0;
  double line_ = 0, line_at_ = 0;  // bytes that waited in line, when
  double rate_ = slowest, round_trip_ = 0.05;
  double way_seen_ = -1;     // s, when the round trip was last found true; below 0: never
  double probe_ = -1;        // s, when the last probe began
  double probed_way_ = 1e9;  // s, the shortest since
};

}  // namespace lcmslam

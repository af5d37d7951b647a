#pragma once
// Colour and depth images of two cameras become shots of one moment.
//
// Two images may be a pair when their times are at most the tolerance apart: colour's stamp, and depth's on
// colour's clock (RgbdCalibration::depth_offset). Two of which each is the
// other's nearest are one; then of what is left, and so on: each image is in one pair at most, and no two
// images would both rather have had each other. A pair is made as soon as no image that may still come can be
// nearer to either.

#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include <lcmslam/cameras/camera_shot.hpp>

namespace lcmslam {

struct PairCounts {
  std::int64_t pairs = 0;
  std::int64_t unmatched_colour = 0, unmatched_depth = 0;
};

class ImagePairs {
 public:
  /// Microseconds. `depth_offset`, added to depth's stamps, gives colour's clock.
  ImagePairs(Utime tolerance, Utime depth_offset) : tolerance_(tolerance), depth_offset_(depth_offset) {}

  /// `utime` is the colour image's stamp, `depth_utime` the depth image's. Each camera's images come in the
  /// order of their stamps; one that is not later than the last is refused (unmatched), unless it is more
  /// than a second earlier: then time has begun anew, and what waited is decided.
  void add_colour(CameraShot frame);
  void add_depth(CameraShot frame);

  /// The next pair, in the order of the colour images: of the other camera it has the depth image, its own
  /// stamp and its amplitude.
  std::optional<CameraShot> next();

  /// No image comes any more: all that wait can be decided.
  void finish();

  /// When a depth image was taken, on colour's clock.
  Utime depth_time(const CameraShot& frame) const { return frame.depth_utime + depth_offset_; }

  PairCounts counts() const { return counts_; }
  /// Of the last colour image that found none while depth images waited, how far the nearest of them was
  /// (us).
  std::optional<Utime> last_miss() const { return last_miss_; }

 private:
  struct Stream {
    std::map<Utime, CameraShot> waiting;  // by time, colour's clock
    Utime last = 0;
    bool begun = false;
    std::deque<Utime> intervals;  // us, the last ones: a hiccup is not remembered for good

    bool is_overdue() const;
    /// Whether an image that has not come yet may have a stamp up to `latest`.
    bool may_give(Utime latest) const;
    /// The stamp of the waiting image that is nearest to `utime`; of two, the earlier.
    std::optional<Utime> nearest(Utime utime) const;
  };
  bool admit(Stream& stream, Utime stamp);
  void give_up_overdue();
  bool decide(Utime given_up);
  bool is_settled(const Stream& other, Utime utime, std::optional<Utime> nearest, Utime given_up) const;
  void make_pair(Utime colour, Utime depth);

  Utime tolerance_, depth_offset_;
  Stream colours_, depths_;
  std::deque<CameraShot> begun_before_;  // pairs of a time that has ended
  std::map<Utime, CameraShot> pairs_;    // by the colour image's stamp
  PairCounts counts_;
  std::optional<Utime> last_miss_;
};

}  // namespace lcmslam

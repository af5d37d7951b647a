#pragma once
// Colour and depth images of two cameras become shots of one moment.
//
// Two images may be a pair when their stamps are at most the tolerance apart. Of all such pairs the closest
// is made first, then the closest of what is left, and so on: each image is in one pair at most, and no two
// images would both rather have had each other. That is decided as soon as no image that may still come can
// change it.

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

struct PairCounts {
  std::int64_t pairs = 0;
  std::int64_t unmatched_colour = 0, unmatched_depth = 0;
};

class ImagePairs {
 public:
  /// Microseconds.
  explicit ImagePairs(Utime tolerance) : tolerance_(tolerance) {}

  /// `utime` is the colour image's stamp, `depth_utime` the depth image's. Each camera's images come in the
  /// order of their stamps; one that is not later than the last is refused (unmatched), unless it is more
  /// than a second earlier: then time has begun anew, and what waited is unmatched.
  void add_colour(RgbdFrame frame);
  void add_depth(RgbdFrame frame);

  /// The next pair that is decided, in the order of time: the colour image, and of the other camera the depth
  /// image, its stamp and its amplitude.
  std::optional<RgbdFrame> next();

  /// No image comes any more: all that wait can be decided.
  void finish();

  PairCounts counts() const { return counts_; }
  /// Of the last colour image that found none while depth images waited, how far the nearest of them was
  /// (us).
  std::optional<Utime> last_miss() const { return last_miss_; }

 private:
  struct Stream {
    std::deque<RgbdFrame> waiting;
    Utime last = 0;
    Utime least_interval = 0;  // seen so far; 0: unknown
    bool begun = false;
    /// Whether an image that has not come yet may have a stamp up to `latest`.
    bool may_give(Utime latest) const;
  };
  struct Group {  // how many of each camera's waiting images belong together
    std::size_t colours = 0, depths = 0;
  };
  bool admit(Stream& stream, Utime stamp);
  std::optional<Group> decided_group() const;
  Group front_group() const;
  void decide(const Group& group);
  void note_miss(Utime colour);

  Utime tolerance_;
  Stream colours_, depths_;
  std::deque<RgbdFrame> pairs_;
  PairCounts counts_;
  std::optional<Utime> last_miss_;
  bool finished_ = false;
};

}  // namespace lcmslam

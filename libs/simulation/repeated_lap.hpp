#pragma once
// A drive of many laps of which three are planned: the middle one is driven again and again, in a whole
// number of images, so that what the cameras see at a moment of it is the same in each lap.

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/simulation/planar_path.hpp>

namespace lcmslam {

class RepeatedLap {
 public:
  static constexpr int planned_laps = 3;

  RepeatedLap() = default;  ///< nothing is repeated: the drive is as planned
  /// `path`: planned_laps laps of `lap_length` m. The drive has `repeats` more and is slower than planned by
  /// as much as makes a lap a multiple of `image_period`, us.
  RepeatedLap(const PlanarPath& path, double lap_length, int repeats, Utime image_period);

  bool repeats() const { return repeats_ > 0; }
  Utime period() const { return period_; }  ///< us
  double more_length() const { return repeats_ * length_; }
  /// When the drive is over whose plan takes so long, s.
  double driven(double planned_duration) const;
  /// The plan's time for the drive's, s.
  double planned(double seconds) const;

  /// The first moment of the drive, us after its start, that is like this one.
  Utime first(Utime elapsed) const;
  /// Whether that one comes again: it lies in the lap that is repeated.
  bool comes_again(Utime first_moment) const;

 private:
  Utime begin_ = 0, period_ = 0;  // us: of the first of the laps that are alike
  int repeats_ = 0;
  double length_ = 0;   // m
  double stretch_ = 1;  // planned s for one driven
};

}  // namespace lcmslam

#pragma once
// The prior of a step: how far the robot moved, and how well that is known.

#include <optional>

#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

/// The odometry's motion with the covariance that the filter believes: the odometry's own (wider when
/// the odometry is visual) plus the noise of the settings. Planar settings keep (x, y, heading) only.
/// A motion that is not finite becomes "no idea": standing still, 0.5 m and 0.5 rad.
Motion motion_prior(const Motion& odometry, const FastSlamSettings& settings);

/// The same where settings.left_plane says that the floor is not flat: how it may rise and fall on the way.
Motion with_ground(Motion motion, const FastSlamSettings& settings);

/// Finite, symmetric, and not so wide that numbers fail.
bool usable(const Motion& motion);

/// What the prior says of a robot's place.
enum class Whereabouts {
  predicted,  ///< it is about where the prior leads
  near,       ///< nobody knows what it did in this one step: it may still see what it saw last
  anywhere    ///< in its map
};

/// Since when nothing tells how the robot moves. An odometry that is lost (a visual one in the dark, a gap)
/// states an error beyond its motion and beyond what the robot's speed allows: it is none, and standing still
/// is the better guess.
class UnknownMotion {
 public:
  explicit UnknownMotion(const FastSlamSettings& settings) : settings_(settings) {}

  /// The robot is not bound to the plane any more.
  void leave_plane(const FastSlamSettings& settings) { settings_ = settings; }

  /// The motion to `utime` from the call before, as motion_prior() gives it where the odometry knows it.
  /// Otherwise standing still: its error goes the same way from step to step, so that sigma and not the
  /// variance grows with the time that nothing is known.
  Motion prior(const Motion& odometry, Utime utime);
  /// That of the last call, of its step alone: without what was unknown before.
  const Motion& step() const { return step_; }
  /// Measurements have told where the robot is.
  void end() { elapsed_ = 0; }
  /// Long enough that it may be anywhere in its map.
  bool lost() const { return 1e-6 * static_cast<double>(elapsed_) > settings_.lost_after; }
  Whereabouts whereabouts() const;

 private:
  bool knows(const Motion& odometry, Utime step) const;

  FastSlamSettings settings_;
  std::optional<Utime> last_;
  Motion step_;
  Utime elapsed_ = 0;  // us, of unknown motion since end()
  Utime before_ = 0;   // the same before the last step
};

}  // namespace lcmslam

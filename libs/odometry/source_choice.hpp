#pragma once
// Which source of odometry is taken where nobody named one.

#include <map>
#include <optional>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// The better one first: wheels know what they err by, another driver's pose only that it moved, and what the
/// camera saw is in the map's measurements already.
enum class OdometrySource { wheels, twist, external, visual };

/// Chooses by what arrives. Wheels are taken at once, for nothing is better. Another source is taken when it
/// has spoken for `patience` s of its own message time, unless a better one has spoken meanwhile, more than
/// once: then that one. Once chosen it stays: two sources' paths begin in different frames. The same messages
/// give the same choice.
class SourceChoice {
 public:
  explicit SourceChoice(double patience);
  /// Nothing is left to choose.
  explicit SourceChoice(OdometrySource named) : patience_(0), chosen_(named) {}

  /// To be told of every message until there is a choice.
  void heard(OdometrySource source, Utime utime);
  const std::optional<OdometrySource>& chosen() const { return chosen_; }

 private:
  double patience_;  // us
  struct Spoken {
    Utime since;
    int messages = 0;
  };
  std::map<OdometrySource, Spoken> spoken_;  // the best first
  std::optional<OdometrySource> chosen_;
};

}  // namespace lcmslam

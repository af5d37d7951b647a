#pragma once
// What is new to the map leads a robot that drives into it, but not against its wheels: something may go with
// it. As long as that does, settled surfaces tell the way or, where they do not suffice, wheels.

#include <lcmslam/dense_mapper/companion.hpp>
#include <lcmslam/dense_mapper/settled_way.hpp>
#include <lcmslam/dense_mapper/tracker.hpp>

namespace lcmslam {

class WheelHold {
 public:
  /// Before a frame is registered: whether something goes with the robot. Only wheels know of it; who is
  /// adrift looks for his place, whatever goes with him.
  bool is_accompanied(const PreparedFrame& prepared, bool adrift);
  /// Afterwards: takes the robot back (Tracked::held) to where wheels and settled surfaces lead it.
  void hold(const PreparedFrame& prepared, const Expectation& expected, Tracked& tracked);

 private:
  SettledWay way_;
  Companion companion_;
};

}  // namespace lcmslam

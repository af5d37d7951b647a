#pragma once
// Driving from afar: one operator at a time, and whoever falls silent has let go.

#include <cstdint>
#include <optional>

namespace lcmslam {

/// Shares of the robot's top speeds, -1..1: forward, and turning left.
struct Drive {
  double linear = 0, angular = 0;
  bool stops() const { return linear == 0 && angular == 0; }
};

class DeadMan {
 public:
  using Operator = std::uint64_t;

  /// `silence` s after which the robot stops.
  explicit DeadMan(double silence = 0.3) : silence_(silence) {}

  /// Values are brought into -1..1; throws std::invalid_argument for one that is not finite. Who comes while
  /// another one drives stops the robot and takes over with his next word; the other one must let go before
  /// he drives again: std::runtime_error tells him. `now` s.
  Drive drive(Operator who, const Drive& wanted, double now);
  /// His link is gone. The stop that is to be sent, when it was he who drove.
  std::optional<Drive> gone(Operator who);
  /// The stop that is to be sent now, once.
  std::optional<Drive> silent(double now);

  /// Whether somebody is driving.
  bool is_driving() const { return driver_ != 0; }

 private:
  double silence_;
  Operator driver_ = 0, ousted_ = 0;  // 0: nobody
  double heard_ = 0, ousted_heard_ = 0;
};

}  // namespace lcmslam

// When the icp process begins another map, and when it does not.

#include <gtest/gtest.h>

#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "procs/icp/icp_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam {
namespace {

using testing::SimulatedKitchen;
using testing::TestBus;
using testing::value_of;

/// A camera without odometry that is away now and then.
class CameraWithGaps : public ::testing::Test {
 protected:
  static constexpr int waiting = 6;  // frames that wait for odometry after a gap

  IcpNode& begin(const char* settings) {
    IcpNode& icp = bus_.add<IcpNode>(ConfigNode::parse(settings));
    bus_.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
    show(0, 3);
    return icp;
  }
  void show(int from, int to) {
    for (int k = from; k <= to; ++k) bus_.deliver("CAMERA", kitchen_.frame(k));
  }
  std::int8_t status() { return bus_.on<pose_estimate_t>("ICP_POSE").back().status; }

 private:
  SimulatedKitchen& kitchen_ = SimulatedKitchen::instance();
  TestBus bus_;
};

// However long the camera was away: the robot is looked for from when it is back.
TEST_F(CameraWithGaps, LeavesTimeToBeFoundAfterALongOne) {
  const IcpNode& icp = begin("{new_map_after: 1}");
  constexpr int back = 90, tries = 10;
  for (int k = back; k <= back + waiting + tries; ++k) {
    show(k, k);
    EXPECT_EQ(value_of(icp, "sessions"), 1) << k;
  }
  EXPECT_EQ(status(), pose_estimate_t::LOST);
  show(back + waiting + tries + 1, back + waiting + tries + 3);
  EXPECT_EQ(value_of(icp, "sessions"), 2);
}

// A second gap is no time in which the robot was looked for.
TEST_F(CameraWithGaps, LeavesTimeToBeFoundAfterTwo) {
  const IcpNode& icp = begin("{new_map_after: 2}");
  constexpr int few = 3;
  for (const int back : {60, 95}) {
    show(back, back + waiting + few);
    EXPECT_EQ(status(), pose_estimate_t::LOST) << back;
  }
  EXPECT_EQ(value_of(icp, "sessions"), 1);
}

// Wheels stand still, and the camera shows another part of the kitchen: whoever wants no new map for that
// gets none, however soon one would begin after a gap.
TEST(IcpSessions, NoneBeginsForACarriedRobotWhereThatIsAsked) {
  SimulatedKitchen& kitchen = SimulatedKitchen::instance();
  for (const bool asked : {true, false}) {
    TestBus bus;
    const IcpNode& icp =
        bus.add<IcpNode>(ConfigNode::parse(asked ? "{new_map_when_carried: 0, new_map_after: 1}"
                                                 : "{new_map_when_carried: 1, new_map_after: 1}"));
    bus.deliver("CAMERA_CALIBRATION", kitchen.calibration());
    MotionSample still;
    still.covariance = 1e-6 * Matrix6d::Identity();
    std::int64_t seq = 0;
    const auto show = [&](int k) {
      const images_t& frame = kitchen.frame(k);
      const Utime until = frame.utime + 60'000;
      for (Utime utime = still.utime == 0 ? frame.utime - 60'000 : still.utime + 50'000; utime <= until;
           utime += 50'000) {
        still.utime = utime;
        odometry_t message = to_message(still, "wheels");
        set_origin(message, Origin{seq++, 1});
        bus.deliver("ODOMETRY", message);
      }
      bus.deliver("CAMERA", frame);
    };
    for (int k = 0; k <= 3; ++k) show(k);
    ASSERT_EQ(bus.on<pose_estimate_t>("ICP_POSE").back().status, pose_estimate_t::TRACKING);
    for (int k = 90; k < 125; ++k) show(k);
    EXPECT_EQ(value_of(icp, "sessions"), asked ? 1 : 2);
    if (asked) {
      EXPECT_EQ(bus.on<pose_estimate_t>("ICP_POSE").back().status, pose_estimate_t::LOST);
    }
  }
}

// What stands on the old mount stays as it was.
TEST(IcpSessions, AnotherMountBeginsAnotherMap) {
  TestBus bus;
  bus.add<OdometryNode>();
  IcpNode& icp = bus.add<IcpNode>();
  SimulatedKitchen& kitchen = SimulatedKitchen::instance();
  kitchen.play(bus, 6);
  const std::size_t keyframes = bus.count("ICP_KEYFRAME");
  camera_calibration_t calibration = kitchen.calibration();
  calibration.depth_noise_quadratic *= 1.01;
  bus.deliver("CAMERA_CALIBRATION", calibration);
  EXPECT_EQ(value_of(icp, "sessions"), 1) << "noise is no mount";
  calibration.T_robot_camera.trans[2] += 0.01;
  bus.deliver("CAMERA_CALIBRATION", calibration);
  EXPECT_EQ(value_of(icp, "sessions"), 2);
  EXPECT_EQ(bus.on<graph_t>("ICP_GRAPH").back().change, 0) << "the old map whole, once more";
  EXPECT_GE(bus.count("ICP_KEYFRAME"), keyframes);
}

}  // namespace
}  // namespace lcmslam

// Before the first landmark: a robot that drives in the dark, or along bare walls.

#include <gtest/gtest.h>

#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam {
namespace {

/// Drives at half a metre a second; its wheels' driver restarts after five.
class DarkDrive : public ::testing::Test {
 protected:
  static constexpr Utime frame_period = 100'000, wheel_period = 20'000;

  void drive(double seconds, std::int64_t sender) {
    const Utime end = now_ + static_cast<Utime>(1e6 * seconds);
    const Utime begin = now_;
    for (; now_ < end; now_ += wheel_period) {
      MotionSample sample;
      sample.utime = now_;
      sample.T_odom_robot = planar_pose(0.5e-6 * static_cast<double>(now_ - begin), 0, 0);
      sample.covariance = 1e-6 * Matrix6d::Identity();
      odometry_t message = to_message(sample, "wheels");
      set_origin(message, Origin{seq_++, sender});
      bus_.deliver("ODOMETRY", message);
      if (now_ % frame_period == 0) look(now_ - wheel_period);
    }
  }
  void look(Utime utime) {
    FeatureFrame frame;
    frame.utime = utime;
    frame.width = 640, frame.height = 480;
    frame.fx = frame.fy = 525;
    frame.has_mount = true;
    features_t message = to_message(frame);
    set_origin(message, Origin{seq_++, 9});
    bus_.deliver("FEATURES", message);
  }

  testing::TestBus bus_;
  FastSlamNode& node_ = bus_.add<FastSlamNode>(ConfigNode::parse("{particles: 20}"));
  Utime now_ = 10'000'000;
  std::int64_t seq_ = 0;
};

TEST_F(DarkDrive, WhoFollowsTheLocalPoseSeesNoLeapWhereTheWorldBeginsAnew) {
  drive(5, 1);
  drive(2, 2);
  const auto local = bus_.on<pose_estimate_t>("FASTSLAM_LOCAL_POSE");
  ASSERT_GT(local.size(), 60U);
  double way = 0;
  for (std::size_t i = 1; i < local.size(); ++i) {
    const double step = distance_between(from_message(local[i - 1].T_map_robot, "pose"),
                                         from_message(local[i].T_map_robot, "pose"));
    EXPECT_LT(step, 0.2) << i;
    way += step;
  }
  EXPECT_GT(way, 3) << "it drives all the time";
}

}  // namespace
}  // namespace lcmslam

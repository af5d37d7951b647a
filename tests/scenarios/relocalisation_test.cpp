// The icp process, without odometry, when its camera is covered and carried to another place of the map.

#include <gmock/gmock.h>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "procs/icp/icp_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam {
namespace {

using testing::SimulatedKitchen;
using testing::TestBus;

constexpr int shown_again = 2, frames_here = 45, dark_frames = 6, frames_there = 8;

Eigen::Isometry3d pose(const pose_estimate_t& message) {
  return from_message(message.T_map_robot, "T_map_robot");
}

class Carried : public ::testing::Test {
 protected:
  /// The k-th frame of the kitchen, taken as the n-th.
  images_t frame_as(int k, int n) {
    images_t message = kitchen_.frame(k);
    const Utime later = kitchen_.frame_time(n) - kitchen_.frame_time(k);
    message.utime += later;
    for (image_t& image : message.images) image.utime += later;
    set_origin(message, {n, 1000});
    return message;
  }

  images_t dark_frame(int n) {
    const RgbdCalibration& calibration = kitchen_.simulation().calibration();
    RgbdFrame frame;
    frame.utime = frame.depth_utime = kitchen_.frame_time(n);
    frame.colour = cv::Mat(calibration.colour.height, calibration.colour.width, CV_8UC3, cv::Scalar::all(0));
    frame.depth = cv::Mat(calibration.depth.height, calibration.depth.width, CV_16UC1, cv::Scalar(0));
    EncodedFrame encoded = encode(frame);
    encoded.sensor = calibration.sensor;
    images_t message = to_message(encoded);
    set_origin(message, {n, 1000});
    return message;
  }

  SimulatedKitchen& kitchen_ = SimulatedKitchen::instance();
};

TEST_F(Carried, FindsItselfInTheMapAgain) {
  TestBus bus;
  bus.add<SurfNode>();
  bus.add<IcpNode>();
  bus.deliver("CAMERA_CALIBRATION", kitchen_.calibration());
  int n = 0;
  for (; n < frames_here; ++n) bus.deliver("CAMERA", kitchen_.frame(n));
  for (; n < frames_here + dark_frames; ++n) bus.deliver("CAMERA", dark_frame(n));
  for (; n < frames_here + dark_frames + frames_there; ++n) bus.deliver("CAMERA", frame_as(shown_again, n));
  bus.finish();

  const auto poses = bus.on<pose_estimate_t>("ICP_POSE");
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(n));
  const Eigen::Isometry3d first_time = pose(poses[shown_again]);
  const Eigen::Isometry3d carried = pose(poses[frames_here - 1]).inverse() * first_time;
  ASSERT_GT(carried.translation().norm() + rotation_angle(carried), 0.5);  // else this tests nothing
  int lost = 0, relocalised = 0;
  for (std::size_t i = frames_here; i < poses.size(); ++i) {
    const bool dark = i < frames_here + dark_frames;
    lost += dark && poses[i].status == pose_estimate_t::LOST ? 1 : 0;
    relocalised += !dark && poses[i].status == pose_estimate_t::RELOCALISED ? 1 : 0;
  }
  EXPECT_EQ(lost, dark_frames);
  EXPECT_EQ(relocalised, 1);
  EXPECT_EQ(poses.back().status, pose_estimate_t::TRACKING);
  const Eigen::Isometry3d error = first_time.inverse() * pose(poses.back());
  EXPECT_LT(error.translation().norm(), 0.03);
  EXPECT_LT(rotation_angle(error), 0.02);
}

}  // namespace
}  // namespace lcmslam

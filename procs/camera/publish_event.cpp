#include "procs/camera/publish_event.hpp"

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>

namespace lcmslam {
namespace {

ground_truth_t truth_message(const GroundTruth& truth) {
  ground_truth_t m;
  m.utime = truth.utime;
  m.frame = "world";
  m.child_frame = truth.child_frame;
  m.T_frame_child = to_message(truth.T_world_child);
  return m;
}

}  // namespace

void publish_event(Publisher& publisher, const CameraEvent& event) {
  if (const auto* frame = std::get_if<EncodedFrame>(&event))
    publisher.publish("CAMERA", to_message(*frame));
  else if (const auto* encoders = std::get_if<Encoders>(&event))
    publisher.publish("ENCODERS", to_message(*encoders));
  else
    publisher.publish("GROUND_TRUTH", truth_message(std::get<GroundTruth>(event)));
}

}  // namespace lcmslam

#include "tools/import/landmark_log.hpp"

#include <algorithm>
#include <functional>
#include <vector>

#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/runtime/log_publisher.hpp>
#include "tools/output_file.hpp"

namespace lcmslam {
namespace {

ground_truth_t truth_message(const StampedPose& pose) {
  ground_truth_t m;
  m.utime = pose.utime;
  m.frame = "world";
  m.child_frame = "robot";
  m.T_frame_child = to_message(pose.T_world_body);
  return m;
}

struct Event {
  Utime utime;
  std::function<void()> publish;
};

}  // namespace

void publish_landmarks(const LandmarkRecording& recording, Publisher& publisher) {
  std::vector<Event> events;  // of one time: truth, motion, features
  for (const StampedPose& pose : recording.truth)
    events.push_back({pose.utime, [&] { publisher.publish("GROUND_TRUTH", truth_message(pose)); }});
  for (const Twist& twist : recording.twists)
    events.push_back({twist.utime, [&] { publisher.publish("TWIST", to_message(twist)); }});
  for (const MotionSample& sample : recording.odometry)
    events.push_back({sample.utime, [&] { publisher.publish("ODOMETRY", to_message(sample, "external")); }});
  for (const FeatureFrame& frame : recording.frames)
    events.push_back({frame.utime, [&] { publisher.publish("FEATURES", to_message(frame)); }});
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.utime < b.utime; });
  for (const Event& event : events) event.publish();
}

LandmarkLogCounts write_landmark_log(const LandmarkRecording& recording, const std::string& file) {
  LogPublisher log(file);
  publish_landmarks(recording, log);
  throw_when_stopped();
  if (recording.frames.empty())
    throw std::runtime_error(file + ": is not written, the recording has no frame");
  log.close();
  LandmarkLogCounts counts;
  for (const FeatureFrame& frame : recording.frames)
    counts.features += static_cast<std::int64_t>(frame.features.size());
  counts.frames = static_cast<std::int64_t>(recording.frames.size());
  counts.motions = static_cast<std::int64_t>(recording.twists.size() + recording.odometry.size());
  counts.truths = static_cast<std::int64_t>(recording.truth.size());
  counts.bytes = log.bytes();
  return counts;
}

}  // namespace lcmslam

// The drive through the kitchen, disturbed in its middle: no map is lost, and nobody claims to track who does
// not.

#include <gmock/gmock.h>

#include <set>

#include <lcmslam/graph_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "procs/icp/icp_node.hpp"
#include "tests/support/recorded_drive.hpp"

namespace lcmslam {
namespace {

using testing::RecordedDrive;
using testing::TestBus;
using testing::value_of;
using Message = RecordedDrive::Message;
using Messages = RecordedDrive::Messages;

constexpr double middle = 14;  // s: the robot turns

/// The same message at another time, of another sender where one is named.
template <class M>
Message moved(const Message& message, double seconds, std::int64_t sender = 0) {
  M m = decode_message<M>(message.second.data(), message.second.size());
  const auto later = static_cast<Utime>(1e6 * seconds);
  m.utime += later;
  if constexpr (std::is_same_v<M, images_t>)
    for (image_t& image : m.images) image.utime += later;
  if (sender != 0) set_origin(m, {origin(m).seq, sender});
  return {message.first, encode_message(m)};
}

Message moved(const Message& message, double seconds, std::int64_t sender = 0) {
  if (message.first == "CAMERA") return moved<images_t>(message, seconds, sender);
  if (message.first == "FEATURES") return moved<features_t>(message, seconds, sender);
  if (message.first == "ENCODERS") return moved<encoders_t>(message, seconds, sender);
  return message;
}

bool is_seen(const Message& message) {
  return message.first == "CAMERA" || message.first == "FEATURES";
}

class Drive {
 public:
  using Disturbance = std::function<Messages(const Message&, double seconds)>;

  explicit Drive(const Disturbance& disturbance = {}, const char* icp_settings = "{}")
      : icp(bus.add<IcpNode>(ConfigNode::parse(icp_settings))) {
    RecordedDrive::Part part;
    part.with_features = true;
    part.disturb = [&](const Message& message, double seconds) {
      if (seconds < middle) {
        landmarks_before = value_of(fastslam, "landmarks");
        keyframes_before = value_of(icp, "keyframes");
      }
      return disturbance ? disturbance(message, seconds) : Messages{message};
    };
    RecordedDrive::instance().play(bus, part);
    bus.finish();
  }

  std::vector<pose_estimate_t> poses(const std::string& channel, const std::string& frame = "map") const {
    std::vector<pose_estimate_t> all = bus.on<pose_estimate_t>(channel);
    all.erase(std::remove_if(all.begin(), all.end(), [&](const auto& m) { return m.frame != frame; }),
              all.end());
    return all;
  }
  double error(const std::string& channel, const std::string& frame = "map") const {
    return RecordedDrive::instance().error_of(poses(channel, frame));
  }
  /// Of icp's graph at the end.
  double final_error() const {
    return RecordedDrive::instance().error_of(bus.on<graph_t>("ICP_GRAPH").back());
  }

  /// Of the poses that claim to be tracked.
  double error_when_tracking(const std::string& channel) const {
    std::vector<pose_estimate_t> tracked = poses(channel);
    tracked.erase(std::remove_if(tracked.begin(), tracked.end(),
                                 [](const auto& m) {
                                   return m.status != pose_estimate_t::TRACKING &&
                                          m.status != pose_estimate_t::RELOCALISED;
                                 }),
                  tracked.end());
    return RecordedDrive::instance().error_of(tracked);
  }

  TestBus bus;
  OdometryNode& odometry = bus.add<OdometryNode>();
  FastSlamNode& fastslam = bus.add<FastSlamNode>(ConfigNode::parse("{particles: 50}"));
  IcpNode& icp;
  double landmarks_before = 0, keyframes_before = 0;
};

const Drive& undisturbed() {
  static const Drive drive;
  return drive;
}

/// s that a pose says TRACKING (or found again) while it is more than 10 cm from where it is without the
/// disturbance, at a stretch.
double longest_false_tracking(const Drive& drive, const std::string& channel) {
  std::map<Utime, Eigen::Vector3d> right;
  for (const pose_estimate_t& m : undisturbed().poses(channel))
    right[m.utime] = from_message(m.T_map_robot, "T_map_robot").translation();
  double longest = 0;
  Utime since = 0;
  for (const pose_estimate_t& m : drive.poses(channel)) {
    const auto there = right.find(m.utime);
    if (there == right.end()) continue;  // a stamp that nobody has without the disturbance
    const Eigen::Vector3d off = from_message(m.T_map_robot, "T_map_robot").translation() - there->second;
    const bool claims = m.status == pose_estimate_t::TRACKING || m.status == pose_estimate_t::RELOCALISED;
    if (!claims || off.norm() < 0.1) since = 0;
    if (claims && off.norm() >= 0.1 && since == 0) since = m.utime;
    if (since != 0) longest = std::max(longest, 1e-6 * static_cast<double>(m.utime - since));
  }
  return longest;
}

class Disturbed : public ::testing::Test {
 protected:
  enum class Bound { of_each_pose, of_the_map };

  /// One map, all of it, and as good as it was: on the way already, or icp's at the end.
  static void expect_map_goes_on(const Drive& drive, Bound bound = Bound::of_each_pose) {
    for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"}) {
      const bool final = bound == Bound::of_the_map && channel == "ICP_POSE";
      const double error = final ? drive.final_error() : drive.error(channel);
      const double error_before = final ? undisturbed().final_error() : undisturbed().error(channel);
      std::cout << channel << ": " << error << " m, undisturbed " << error_before
                << " m, tracked falsely for " << longest_false_tracking(drive, channel) << " s\n";
      EXPECT_LT(error, 2 * error_before) << channel;
      EXPECT_LE(longest_false_tracking(drive, channel), 1) << channel;
    }
    EXPECT_EQ(value_of(drive.fastslam, "sessions"), 1);
    EXPECT_EQ(value_of(drive.icp, "sessions"), 1);
    EXPECT_GT(drive.landmarks_before, 1000);
    EXPECT_GE(value_of(drive.fastslam, "landmarks"), drive.landmarks_before);
    EXPECT_GE(value_of(drive.icp, "keyframes"), drive.keyframes_before);
  }
};

TEST_F(Disturbed, ByWrongStamps) {
  constexpr double years = 1e10;  // s: no time at all, and counted as such
  const Drive drive([&](const Message& message, double seconds) {
    Messages all = {message};
    if (seconds < middle || !is_seen(message)) return all;
    for (const double wrong : {10.0, -10.0, years, -years}) all.push_back(moved(message, wrong));
    return all;
  });
  for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"})
    EXPECT_EQ(drive.poses(channel).size(), undisturbed().poses(channel).size());
  for (const std::size_t i : {1U, 2U}) EXPECT_GT(drive.bus.stamps(i).refused(), 60);
  expect_map_goes_on(drive);
}

TEST_F(Disturbed, ByASecondCamera) {
  Message earlier;
  const Drive drive([&](const Message& message, double seconds) {
    Messages all = {message};
    if (!is_seen(message)) return all;
    if (seconds > 5 && seconds < 6 && message.first == "FEATURES") earlier = message;
    if (seconds > middle && message.first == "FEATURES")
      all.push_back(moved(earlier, seconds - 5.5, 777));  // what it sees is elsewhere
    if (seconds > middle && message.first == "CAMERA") all.push_back(moved(message, 0.1, 777));
    return all;
  });
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_GT(drive.bus.stamps(i).foreign(), 30);
    EXPECT_THAT(drive.bus.stamps(i).trouble(), ::testing::HasSubstr("777"));
  }
  expect_map_goes_on(drive);
}

// The wheels lead on meanwhile, and err by 7 cm, which icp finds out when it sees the old part of its map
// again.
TEST_F(Disturbed, ByACameraThatIsAwayForSixSeconds) {
  const Drive drive([&](const Message& message, double seconds) {
    return is_seen(message) && seconds > middle && seconds < middle + 6 ? Messages{} : Messages{message};
  });
  expect_map_goes_on(drive, Bound::of_the_map);
  EXPECT_EQ(value_of(drive.fastslam, "gaps"), 1);
  EXPECT_EQ(value_of(drive.icp, "gaps"), 1);
  for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"})
    EXPECT_EQ(drive.poses(channel).back().status, pose_estimate_t::TRACKING) << channel;
}

// The robot goes on in a part that it has not seen yet, and comes by its way again at 22 s.
TEST_F(Disturbed, ByAPauseOfEverythingThatLeavesItInAnUnknownPlace) {
  // Odometry is soon believed where the map ends, but not after a gap.
  const Drive drive(
      [&](const Message& message, double seconds) {
        return seconds > middle && seconds < middle + 5 ? Messages{} : Messages{message};
      },
      "{reseed_after: 2}");
  EXPECT_EQ(value_of(drive.icp, "gaps"), 1);
  EXPECT_EQ(value_of(drive.icp, "sessions"), 1);
  EXPECT_EQ(value_of(drive.fastslam, "sessions"), 1);
  EXPECT_GE(value_of(drive.icp, "keyframes"), drive.keyframes_before);
  EXPECT_GE(value_of(drive.fastslam, "landmarks"), drive.landmarks_before);
  EXPECT_LE(longest_false_tracking(drive, "ICP_POSE"), 1);
  double lost_variance = 0;
  for (const pose_estimate_t& m : drive.poses("ICP_POSE")) {
    if (m.status != pose_estimate_t::LOST) continue;
    EXPECT_GT(m.covariance[0], lost_variance) << "it grows";
    lost_variance = m.covariance[0];
  }
  EXPECT_GT(lost_variance, 1);  // m^2
  EXPECT_EQ(drive.poses("ICP_POSE").back().status, pose_estimate_t::TRACKING);
  EXPECT_LT(drive.error_when_tracking("ICP_POSE"), 2 * undisturbed().error("ICP_POSE"));
}

// What the robot saw from the start of the drive to the middle comes once more, and then the rest.
TEST_F(Disturbed, ByALogThatGoesBackTenSeconds) {
  Messages again;
  bool jumped = false;
  const Drive drive([&](const Message& message, double seconds) {
    Messages all;
    if (seconds > 4 && seconds < middle) again.push_back(message);
    if (seconds > middle && !jumped) all = again;
    jumped = jumped || seconds > middle;
    all.push_back(message);
    return all;
  });
  EXPECT_EQ(value_of(drive.fastslam, "sessions"), 2);
  EXPECT_EQ(value_of(drive.icp, "sessions"), 2);
  for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"}) {
    EXPECT_LT(drive.error(channel, "map-2"), 2 * undisturbed().error(channel)) << channel;
    for (const pose_estimate_t& m : drive.poses(channel, "map-2"))
      ASSERT_THAT(m.detail, ::testing::HasSubstr("where map-2 lies in map is not known"));
  }
  // The first session's map is told whole, under its own frame, and what follows does not touch it.
  std::set<std::int64_t> landmarks;
  bool second = false;
  for (const landmarks_t& m : drive.bus.on<landmarks_t>("FASTSLAM_LANDMARKS")) {
    second = second || m.frame == "map-2";
    EXPECT_EQ(m.frame, second ? "map-2" : "map");
    if (second) continue;
    for (const landmark_t& landmark : m.landmarks) landmarks.insert(landmark.id);
    for (const std::int64_t id : m.removed) landmarks.erase(id);
  }
  EXPECT_TRUE(second);
  EXPECT_GT(landmarks.size(), 500U);
  std::map<std::string, std::set<std::int32_t>> keyframes;
  for (const keyframe_t& m : drive.bus.on<keyframe_t>("ICP_KEYFRAME")) keyframes[m.frame].insert(m.id);
  EXPECT_GE(static_cast<double>(keyframes["map"].size()), drive.keyframes_before);
  EXPECT_GT(keyframes["map-2"].size(), 10U);
}

TEST_F(Disturbed, ByAResetThatBeginsAMapBesideTheOld) {
  TestBus bus;
  bus.add<OdometryNode>();
  const FastSlamNode& fastslam = bus.add<FastSlamNode>(ConfigNode::parse("{particles: 20}"));
  const IcpNode& icp = bus.add<IcpNode>();
  RecordedDrive::Part part;
  part.with_features = true;
  part.to = 4;
  RecordedDrive::instance().play(bus, part);
  bus.command("reset");
  part.from = 4;
  part.to = 6;
  RecordedDrive::instance().play(bus, part);
  bus.finish();
  EXPECT_EQ(value_of(fastslam, "sessions"), 2);
  EXPECT_EQ(value_of(icp, "sessions"), 2);
  for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"}) {
    std::set<std::string> frames;
    for (const auto& m : bus.on<pose_estimate_t>(channel)) frames.insert(m.frame);
    EXPECT_THAT(frames, ::testing::ElementsAre("map", "map-2"));
  }
  std::set<std::string> frames;
  for (const auto& m : bus.on<keyframe_t>("ICP_KEYFRAME")) frames.insert(m.frame);
  EXPECT_THAT(frames, ::testing::ElementsAre("map", "map-2"));
}

// Launch names the process that it starts again another map.
TEST_F(Disturbed, ByAKilledMapperWhoseSuccessorDoesNotKnowWhereItIs) {
  TestBus bus;
  bus.add<OdometryNode>();
  bus.add<FastSlamNode>(ConfigNode::parse("{particles: 20, map_frame: map-restart-1}"));
  bus.add<IcpNode>(ConfigNode::parse("{map_frame: map-restart-1}"));
  RecordedDrive::Part part;
  part.with_features = true;
  part.to = 4;
  RecordedDrive::instance().play(bus, part);
  bus.finish();
  for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"}) {
    const auto poses = bus.on<pose_estimate_t>(channel);
    ASSERT_EQ(poses.size(), 6U);
    for (const auto& m : poses) {
      EXPECT_EQ(m.frame, "map-restart-1");
      EXPECT_EQ(m.detail, "where map-restart-1 lies in map is not known");
    }
  }
  for (const auto& m : bus.on<landmarks_t>("FASTSLAM_LANDMARKS")) EXPECT_EQ(m.frame, "map-restart-1");
}

}  // namespace
}  // namespace lcmslam

// Algorithm 3.2 in its process: frames wait for their features, with wheels and without, however late
// they come.

#include <gmock/gmock.h>

#include <algorithm>

#include <lcmslam/features_t.hpp>
#include <lcmslam/odometry_t.hpp>
#include "procs/icp/icp_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam {
namespace {

using testing::SimulatedKitchen;
using testing::TestBus;
using testing::value_of;

constexpr int thesis_frames = 10;
constexpr const char* alternating =
    "{variant: alternating, graph: {enabled: false}, "
    "thesis: {registration: {max_distance: 0.2, distance_sigmas: 3}}}";

/// What camera, surf and, where there are wheels, odometry say, in the order of their making.
std::vector<testing::Published> recorded(bool wheels) {
  TestBus bus;
  if (wheels) bus.add<OdometryNode>();
  bus.add<SurfNode>(ConfigNode::parse("{max_features: 400}"));
  SimulatedKitchen::instance().play(bus, thesis_frames);
  bus.finish();
  return bus.published();
}

struct ThesisRun {
  std::vector<pose_estimate_t> poses;
  double with = 0, without = 0;
};

/// Features reach the mapper `late` s of message time after their image.
ThesisRun mapped(const std::vector<testing::Published>& made, const std::string& settings, double late) {
  struct Event {
    Utime when;
    std::string channel;
    std::vector<std::uint8_t> bytes;
  };
  std::vector<Event> events;
  auto& kitchen = SimulatedKitchen::instance();
  for (int k = 0; k < thesis_frames; ++k)
    events.push_back({kitchen.frame_time(k), "CAMERA", encode_message(kitchen.frame(k))});
  for (const auto& message : made) {
    if (message.channel == "ODOMETRY") {
      odometry_t m;
      m.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size()));
      events.push_back({m.utime, message.channel, message.bytes});
    } else if (message.channel == "FEATURES") {
      features_t m;
      m.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size()));
      events.push_back({m.utime + static_cast<Utime>(1e6 * late), message.channel, message.bytes});
    }
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.when < b.when; });
  TestBus bus;
  IcpNode& icp = bus.add<IcpNode>(ConfigNode::parse(settings));
  bus.deliver("CAMERA_CALIBRATION", kitchen.calibration());
  for (const Event& event : events) bus.deliver(event.channel, event.bytes);
  bus.finish();
  return {bus.on<pose_estimate_t>("ICP_POSE"), value_of(icp, "with_features"),
          value_of(icp, "without_features")};
}

class Features : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Wheels, Features, ::testing::Bool());

TEST_P(Features, AreWaitedForHoweverLateTheyCome) {
  const auto made = recorded(GetParam());
  const ThesisRun early = mapped(made, alternating, 0.01), late = mapped(made, alternating, 0.25);
  for (const ThesisRun& run : {early, late}) {
    ASSERT_EQ(run.poses.size(), static_cast<std::size_t>(thesis_frames));
    EXPECT_EQ(run.with, thesis_frames);
    EXPECT_EQ(run.without, 0);
  }
  for (std::size_t i = 0; i < early.poses.size(); ++i)
    EXPECT_EQ(encode_message(early.poses[i].T_map_robot), encode_message(late.poses[i].T_map_robot)) << i;
}

TEST(LateFeatures, AreCountedWhereTheWaitIsShorter) {
  const auto made = recorded(false);
  const std::string short_wait =
      "{variant: alternating, graph: {enabled: false}, thesis: {features_wait: 0.05}}";
  const ThesisRun run = mapped(made, short_wait, 0.35);
  EXPECT_EQ(run.poses.size(), static_cast<std::size_t>(thesis_frames));
  EXPECT_GT(run.without, thesis_frames / 2);
  EXPECT_EQ(run.with + run.without, thesis_frames);
}

}  // namespace
}  // namespace lcmslam

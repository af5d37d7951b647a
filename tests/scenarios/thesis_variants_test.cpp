// The thesis's registrations in the icp process, as config/thesis.yaml has them, on the simulated kitchen.

#include <gmock/gmock.h>

#include <lcmslam/icp_report_t.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include "procs/icp/icp_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam {
namespace {

using testing::SimulatedKitchen;
using testing::TestBus;

class ThesisVariants : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Variants, ThesisVariants, ::testing::Values("plain", "alternating", "frustum"));

TEST_P(ThesisVariants, FollowTheRobot) {
  ConfigNode config = ConfigNode::load(LCMSLAM_SOURCE_DIR "/config/thesis.yaml").section("icp");
  config.set("variant", GetParam());
  TestBus bus;
  bus.add<OdometryNode>();
  bus.add<SurfNode>(ConfigNode::parse("{max_features: 400}"));
  bus.add<IcpNode>(config);
  constexpr int frames = 12;
  SimulatedKitchen::instance().play(bus, frames);
  bus.finish();

  const auto poses = bus.on<pose_estimate_t>("ICP_POSE");
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(frames));
  for (const double error : SimulatedKitchen::instance().position_errors(poses)) EXPECT_LT(error, 0.05);
  for (const pose_estimate_t& m : poses) EXPECT_EQ(m.status, pose_estimate_t::TRACKING);
  for (const icp_report_t& report : bus.on<icp_report_t>("ICP_REPORT"))
    EXPECT_THAT(report.variant, ::testing::StartsWith(GetParam()));
}

TEST(ThesisVariantSettings, WrongOnesAreRefused) {
  for (const char* wrong :
       {"{variant: sideways}", "{thesis: {pairing: both}}", "{thesis: {cloud_iterations: 0}}",
        "{thesis: {registration: {solver: magic}}}", "{thesis: {overlap: {scale: 2}}}"}) {
    TestBus bus;
    EXPECT_THROW(bus.add<IcpNode>(ConfigNode::parse(wrong)), ConfigError) << wrong;
  }
}

}  // namespace
}  // namespace lcmslam

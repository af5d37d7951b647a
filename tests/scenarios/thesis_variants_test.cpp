// Keys of the thesis's registrations. What they achieve: drive_test.cpp.

#include <gmock/gmock.h>

#include "procs/icp/icp_node.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam {
namespace {

using testing::TestBus;

TEST(ThesisVariantSettings, WrongOnesAreRefused) {
  for (const char* wrong :
       {"{variant: sideways}", "{thesis: {pairing: both}}", "{thesis: {cloud_iterations: -1}}",
        "{thesis: {cloud_iterations: 0, feature_iterations: 0}}", "{thesis: {registration: {solver: magic}}}",
        "{thesis: {overlap: {scale: 2}}}"}) {
    TestBus bus;
    EXPECT_THROW(bus.add<IcpNode>(ConfigNode::parse(wrong)), ConfigError) << wrong;
  }
}

}  // namespace
}  // namespace lcmslam

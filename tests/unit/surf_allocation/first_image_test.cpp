// What a camera's first image has made, the images behind it wait for.
#include <gtest/gtest.h>

#include "procs/surf/surf_node.hpp"
#include "tests/support/simulated_kitchen.hpp"
#include "tests/unit/surf_allocation/malloc_count.hpp"

namespace lcmslam {
namespace {

using testing::SimulatedKitchen;

/// Bytes that are asked of malloc.
long bytes_of(testing::TestBus& bus, const std::string& channel, const images_t& message) {
  const long before = testing::malloc_bytes();
  bus.deliver(channel, message);
  return testing::malloc_bytes() - before;
}

TEST(FirstImage, FindsItsBuffersMade) {
  if (testing::malloc_calls() == 0) GTEST_SKIP() << "the sanitizer's malloc cannot be counted";
  SimulatedKitchen& kitchen = SimulatedKitchen::instance();
  testing::TestBus bus;
  bus.add<SurfNode>();
  bus.deliver("CAMERA_CALIBRATION", kitchen.calibration());
  const long first = bytes_of(bus, "CAMERA", kitchen.frame(0));
  const long second = bytes_of(bus, "CAMERA", kitchen.frame(1));
  EXPECT_LT(2 * first, 5 * second);  // what finds planes is made with the first depths
  EXPECT_EQ(bus.count("FEATURES"), 2U);
}

}  // namespace
}  // namespace lcmslam

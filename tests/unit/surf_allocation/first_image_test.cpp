// What a camera's first image has made, the images behind it wait for.
#include <gtest/gtest.h>

#include <lcmslam/messages/feature_messages.hpp>
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
  testing::TestBus cold, warm;
  cold.add<SurfNode>();
  warm.add<SurfNode>();
  warm.deliver("CAMERA_CALIBRATION", kitchen.calibration());
  const long first = bytes_of(warm, "CAMERA", kitchen.frame(0));
  const long second = bytes_of(warm, "CAMERA", kitchen.frame(1));
  EXPECT_LT(2 * first, 5 * second);  // what finds planes is made with the first depths
  EXPECT_EQ(warm.count("FEATURES"), 2U);

  // It is not seen in what is published.
  cold.deliver("CAMERA", kitchen.frame(0));
  cold.deliver("CAMERA_CALIBRATION", kitchen.calibration());
  const auto expected = cold.on<features_t>("FEATURES"), found = warm.on<features_t>("FEATURES");
  ASSERT_EQ(expected.size(), 1U);
  EXPECT_EQ(encode_message(found[0]), encode_message(expected[0]));
}

}  // namespace
}  // namespace lcmslam

#include <lcmslam/features/descriptor_distance.hpp>

#include <gtest/gtest.h>

#include <vector>

#include <lcmslam/features/dot_product_distance.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

constexpr InstructionSet all_sets[] = {InstructionSet::portable, InstructionSet::sse2, InstructionSet::avx2};

// Any bytes, among them the extremes.
Descriptor any_descriptor(Random& random) {
  Descriptor descriptor;
  const std::uint64_t kind = random.below(4);
  for (auto& byte : descriptor)
    byte = static_cast<std::uint8_t>(kind == 0 ? 255 * random.below(2) : kind == 1 ? 255 : random.below(256));
  return descriptor;
}

class DescriptorDistanceTest : public testing::TestWithParam<bool> {
 protected:
  DescriptorDistanceTest() : before_(allow_dot_products(GetParam())) {}
  ~DescriptorDistanceTest() override { allow_dot_products(before_); }

 private:
  bool before_;
};

TEST_P(DescriptorDistanceTest, EveryInstructionSetEqualsDirectSummation) {
  EXPECT_TRUE(GetParam() || dot_product_distances() == nullptr);
  for (const InstructionSet set : all_sets) {
    if (!has(set)) continue;
    const DistanceFunction distances_of = distance_function(set);
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
      Random random(seed);
      Descriptor queries[4];
      WideDescriptor wide[4];
      for (int q = 0; q < 4; ++q) wide[q].assign(queries[q] = any_descriptor(random));
      std::vector<Descriptor> targets(random.below(40));
      std::vector<std::int32_t> norms2;
      for (auto& target : targets) norms2.push_back(squared_norm(target = any_descriptor(random)));
      Int4 distances[40];
      const WideDescriptor* const group[4] = {&wide[0], &wide[1], &wide[2], &wide[3]};
      distances_of(group, targets.data(), norms2.data(), int(targets.size()), distances);
      for (std::size_t t = 0; t < targets.size(); ++t)
        for (int q = 0; q < 4; ++q)
          ASSERT_EQ(distances[t][q], squared_distance(queries[q], targets[t]))
              << "seed " << seed << ", set " << int(set);
      std::int32_t lone[40];
      lone_distance_function(set)(wide[0], targets.data(), norms2.data(), int(targets.size()), lone);
      for (std::size_t t = 0; t < targets.size(); ++t) ASSERT_EQ(lone[t], distances[t][0]) << "seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(DotProducts, DescriptorDistanceTest, testing::Bool());

TEST(DescriptorDistance, TheBestSetIsThere) {
  EXPECT_TRUE(has(InstructionSet::portable));
  EXPECT_TRUE(has(best_instruction_set()));
  if (!has(InstructionSet::avx2)) {
    EXPECT_THROW(distance_function(InstructionSet::avx2), std::invalid_argument);
    EXPECT_THROW(lone_distance_function(InstructionSet::avx2), std::invalid_argument);
  }
}

TEST(DescriptorDistance, AnyFindsEachLane) {
  EXPECT_FALSE(any(Int4{0, 0, 0, 0}));
  for (int lane = 0; lane < 4; ++lane) {
    Int4 one{0, 0, 0, 0};
    one[lane] = -1;
    EXPECT_TRUE(any(one));
  }
}

}  // namespace
}  // namespace lcmslam

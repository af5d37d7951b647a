#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

#include "fastslam/persistent_array.hpp"
#include "geometry/random.hpp"

namespace lcmslam {
namespace {

using Array = PersistentArray<int>;
using Reference = std::map<std::size_t, int>;

void expect_equal(const Array& array, const Reference& reference, std::size_t limit) {
  for (std::size_t i = 0; i < limit; ++i) {
    const int* found = array.find(i);
    const auto expected = reference.find(i);
    if (expected != reference.end()) {
      ASSERT_NE(found, nullptr) << i;
      ASSERT_EQ(*found, expected->second) << i;
    } else if (found) {
      ASSERT_EQ(*found, 0) << i;  // a neighbour in the leaf: default value
    }
  }
}

TEST(PersistentArray, EqualsPlainMapsUnderRandomWritesAndCopies) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::size_t limit = seed < 3 ? 60 : 5000;
    std::vector<Array> arrays(6);
    std::vector<Reference> references(6);
    for (int operation = 0; operation < 20000; ++operation) {
      const auto a = static_cast<std::size_t>(random.below(6)), b = static_cast<std::size_t>(random.below(6));
      if (random.below(20) == 0) {  // resampling: one map becomes another's copy
        arrays[a] = arrays[b];
        references[a] = references[b];
      } else {
        const auto index = static_cast<std::size_t>(random.below(limit));
        const int value = static_cast<int>(random.below(1000)) + 1;
        arrays[a].edit(index) = value;
        references[a][index] = value;
      }
    }
    for (std::size_t k = 0; k < 6; ++k) expect_equal(arrays[k], references[k], limit + 20);
  }
}

TEST(PersistentArray, DifferenceFindsEveryChangeAndVisitsLittleElse) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::size_t size = 1 + static_cast<std::size_t>(random.below(3000));
    Array before;
    for (std::size_t i = 0; i < size; ++i) before.edit(i) = static_cast<int>(i) + 1;
    Array after = before;
    std::set<std::size_t> written;
    for (int n = 0; n < 10; ++n) {  // some beyond the old size: the tree grows
      const auto i = static_cast<std::size_t>(random.below(2 * size));
      after.edit(i) = -1;
      written.insert(i);
    }
    std::set<std::size_t> changed;
    std::size_t visited = 0;
    Array::for_each_difference(before, after, [&](std::size_t i, const int* old, const int& now) {
      ++visited;
      EXPECT_TRUE(i >= size || (old && *old == static_cast<int>(i) + 1));
      if (now == -1) changed.insert(i);
    });
    EXPECT_EQ(changed, written);
    EXPECT_LE(visited, 8 * written.size());
  }
}

TEST(PersistentArray, CopiesShareWhatIsEqual) {
  Array a;
  for (std::size_t i = 0; i < 1000; ++i) a.edit(i) = 1;
  const int* unique_before = a.find(500);
  a.edit(500) = 2;
  EXPECT_EQ(a.find(500), unique_before) << "a sole owner writes in place";
  Array b = a;
  EXPECT_EQ(a.find(500), b.find(500));
  b.edit(500) = 3;
  EXPECT_EQ(*a.find(500), 2);
  EXPECT_EQ(*b.find(500), 3);
  EXPECT_EQ(a.find(900), b.find(900)) << "the rest stays shared";
}

TEST(PersistentArray, EmptyHasNothing) {
  const Array a;
  EXPECT_EQ(a.find(0), nullptr);
  EXPECT_EQ(a.find(1 << 20), nullptr);
  a.for_each([](std::size_t, int) { FAIL() << "nothing to visit"; });
}

}  // namespace
}  // namespace lcmslam

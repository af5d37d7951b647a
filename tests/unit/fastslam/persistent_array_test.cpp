#include <gtest/gtest.h>

#include <map>
#include <set>
#include <thread>
#include <vector>

#include <lcmslam/fastslam/landmarks/persistent_array.hpp>
#include <lcmslam/geometry/random.hpp>

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

TEST(PersistentArray, EditorWritesAsEditDoes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Array array;
    Reference reference;
    for (int round = 0; round < 30; ++round) {
      const Array copy = array;
      const Reference former = reference;
      Array::Editor edit(array);
      for (int i = 0; i < 40; ++i) {  // near each other, in no order; now and then beyond the end
        const auto index = static_cast<std::size_t>(50 * round / 2 + random.below(60));
        const int value = static_cast<int>(random.below(1000)) + 1;
        edit[index] = value;
        reference[index] = value;
      }
      expect_equal(array, reference, 1000);
      expect_equal(copy, former, 1000);
    }
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

// Arrays that share their nodes, each changed by one thread: run under TSan or ASan this also finds races.
TEST(PersistentArray, ThreadsMayChangeCopies) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Array original;
    for (std::size_t i = 0; i < 2000; ++i) original.edit(i) = static_cast<int>(i);
    std::vector<Array> copies(8, original);
    original = Array();  // so that the last of two owners may keep a node
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < copies.size(); ++t)
      threads.emplace_back([&, t] {
        Random random(seed, t);
        for (int n = 0; n < 3000; ++n) {
          const auto i = static_cast<std::size_t>(random.below(2000));
          copies[t].edit(i) = static_cast<int>(i + 10'000 * (t + 1));
        }
      });
    for (std::thread& thread : threads) thread.join();
    for (std::size_t t = 0; t < copies.size(); ++t) {
      Random random(seed, t);
      std::set<std::size_t> written;
      for (int n = 0; n < 3000; ++n) written.insert(static_cast<std::size_t>(random.below(2000)));
      for (std::size_t i = 0; i < 2000; ++i)
        ASSERT_EQ(*copies[t].find(i), static_cast<int>(i + (written.count(i) ? 10'000 * (t + 1) : 0)))
            << "seed " << seed << " copy " << t;
    }
  }
}

TEST(PersistentArray, NodesTellWhatIsShared) {
  Array a;
  for (std::size_t i = 0; i < 1000; ++i) a.edit(i) = 1;
  Array b = a;
  b.edit(500) = 2;
  std::set<const void*> nodes;
  std::size_t count = 0;
  for (const Array* array : {&a, &b})
    array->for_each_node([&](const void* node, std::size_t bytes) {
      EXPECT_GT(bytes, 8 * sizeof(int));
      nodes.insert(node);
      ++count;
    });
  EXPECT_EQ(count, 2 * (125u + 8u + 1u)) << "leaves, their parents, the root";
  EXPECT_EQ(nodes.size(), count / 2 + 3) << "one path of its own";
}

TEST(PersistentArray, EmptyHasNothing) {
  const Array a;
  EXPECT_EQ(a.find(0), nullptr);
  EXPECT_EQ(a.find(1 << 20), nullptr);
  a.for_each([](std::size_t, int) { FAIL() << "nothing to visit"; });
}

}  // namespace
}  // namespace lcmslam

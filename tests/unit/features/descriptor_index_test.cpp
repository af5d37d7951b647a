#include <lcmslam/features/descriptor_index.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <stdexcept>

#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tests/support/heap_allocations.hpp"
#include "tests/support/recorded_features.hpp"
#include "tests/support/recordings.hpp"

namespace lcmslam {
namespace {

using testing::HasSubstr;

// Around one of a few centres, so that the lists have something to find.
Feature clustered_feature(Random& random, double spread = 12) {
  Random centre(1 + random.below(20));
  Feature feature;
  for (auto& byte : feature.descriptor)
    byte = static_cast<std::uint8_t>(
        std::clamp(128 + 16 * centre.normal() + spread * random.normal(), 0., 255.));
  feature.laplacian = random.uniform() < 0.4 ? std::int8_t(-1) : std::int8_t(1);
  return feature;
}

std::vector<Feature> clustered_features(std::uint64_t seed, std::size_t count) {
  Random random(seed, 2);
  std::vector<Feature> features(count);
  for (Feature& f : features) f = clustered_feature(random);
  return features;
}

Neighbours exact_neighbours(const Feature& query, const std::map<int, Feature>& map) {
  std::vector<std::pair<int, int>> order;
  for (const auto& [id, feature] : map)
    if (feature.laplacian == query.laplacian)
      order.emplace_back(squared_distance(query.descriptor, feature.descriptor), id);
  std::sort(order.begin(), order.end());
  Neighbours result;
  for (std::size_t i = 0; i < std::min(order.size(), result.size()); ++i)
    result[i] = {order[i].second, order[i].first};
  return result;
}

void expect_same(const Neighbours& found, const Neighbours& expected, const std::string& where) {
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].id, expected[k].id) << where << ", neighbour " << k;
    EXPECT_EQ(found[k].distance2, expected[k].distance2) << where << ", neighbour " << k;
  }
}

// The lists hold exactly what was put in, each list within its bounds.
void expect_holds(const DescriptorIndex& index, const std::map<int, Feature>& map) {
  ASSERT_EQ(index.size(), int(map.size()));
  std::set<int> seen;
  for (const bool dark : {false, true}) {
    const auto& lists = index.lists(dark);
    int size = 0;
    ASSERT_EQ(lists.lists.size(), lists.centres.size());
    for (std::size_t l = 0; l < lists.lists.size(); ++l) {
      const auto& list = lists.lists[l];
      EXPECT_LT(list.ids.size(), std::size_t(DescriptorIndex::list_capacity));
      EXPECT_FALSE(list.ids.empty());
      EXPECT_EQ(lists.centre_norms2[l], squared_norm(lists.centres[l]));
      size += int(list.ids.size());
      for (std::size_t i = 0; i < list.ids.size(); ++i) {
        ASSERT_TRUE(map.count(list.ids[i]));
        seen.insert(list.ids[i]);
        EXPECT_EQ(list.norms2[i], squared_norm(list.descriptors[i]));
      }
    }
    EXPECT_EQ(size, lists.size);
  }
  EXPECT_EQ(seen.size(), map.size());
  for (const auto& [id, feature] : map) {
    EXPECT_TRUE(index.contains(id));
    EXPECT_EQ(index.descriptor(id), feature.descriptor);
    EXPECT_EQ(index.is_dark(id), feature.laplacian >= 0);
  }
}

TEST(DescriptorIndex, HoldsWhatWasInsertedUpdatedAndRemoved) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    DescriptorIndex index;
    std::map<int, Feature> map;
    // Grows, then shrinks to nothing.
    for (int step = 0; step < 4000; ++step) {
      const int id = int(random.below(1500));
      const bool growing = step < 2500;
      if (!map.count(id)) {
        if (!growing && step % 4) continue;
        map[id] = clustered_feature(random);
        index.insert(id, map[id].descriptor, map[id].laplacian);
      } else if (random.uniform() < (growing ? 0.6 : 0.1)) {
        map[id].descriptor = clustered_feature(random).descriptor;
        index.update(id, map[id].descriptor);
      } else {
        map.erase(id);
        index.remove(id);
      }
      if (step % 500 == 0) expect_holds(index, map);
    }
    expect_holds(index, map);
    while (!map.empty()) {
      index.remove(map.begin()->first);
      map.erase(map.begin());
    }
    expect_holds(index, map);
    EXPECT_TRUE(index.lists(true).lists.empty());
  }
}

TEST(DescriptorIndex, TwinsAndStrangersSplitToo) {
  DescriptorIndex index;
  std::map<int, Feature> map;
  Feature twin;
  twin.laplacian = 1;
  twin.descriptor.fill(128);
  for (int id = 0; id < 1000; ++id) {
    map[id] = twin;
    if (id % 97 == 0) map[id].descriptor.fill(std::uint8_t(id / 4));
    index.insert(id, map[id].descriptor, 1);
  }
  expect_holds(index, map);
  // No part of a split is small, so there are never many lists.
  EXPECT_LE(index.lists(true).lists.size(), 8u * 1000 / DescriptorIndex::list_capacity);
  DescriptorSearch search;
  EXPECT_EQ(search.nearest({twin}, index)[0][0].distance2, 0);
}

TEST(DescriptorIndex, ManyChangesLeaveFewLists) {
  Random random(1);
  DescriptorIndex index;
  for (int id = 0; id < 30000; ++id) {  // a map that forgets: 500 landmarks at any time
    const Feature f = clustered_feature(random, 25);
    index.insert(id % 5000, f.descriptor, f.laplacian);
    if (id >= 500) index.remove((id - 500) % 5000);
  }
  EXPECT_EQ(index.size(), 500);
  EXPECT_LE(index.lists(false).lists.size() + index.lists(true).lists.size(),
            2 + 8u * 500 / DescriptorIndex::list_capacity);
}

TEST(DescriptorIndex, RefusesWhatDoesNotFit) {
  DescriptorIndex index;
  const Descriptor descriptor{};
  index.insert(7, descriptor, 1);
  const auto message = [&](auto call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  EXPECT_THAT(message([&] { index.insert(-1, descriptor, 1); }), HasSubstr("id -1 must be 0 to"));
  EXPECT_THAT(message([&] { index.insert(1 << 24, descriptor, 1); }), HasSubstr("must be 0 to 16777215"));
  EXPECT_THAT(message([&] { index.insert(7, descriptor, -1); }), HasSubstr("id 7 is in the index already"));
  EXPECT_THAT(message([&] { index.update(6, descriptor); }), HasSubstr("id 6 is not in the index"));
  EXPECT_THAT(message([&] { index.remove(8); }), HasSubstr("id 8 is not in the index"));
  EXPECT_THAT(message([&] { index.descriptor(-5); }), HasSubstr("id -5 is not in the index"));
  DescriptorSearch search;
  EXPECT_THAT(message([&] { search.nearest({}, index, {3}); }), HasSubstr("id 3 is not in the index"));
  EXPECT_THAT(message([&] { search.match({}, index, 0.); }), HasSubstr("ratio"));
  EXPECT_THAT(message([&] { DescriptorSearch({0, 1}); }), HasSubstr("share is 0"));
  EXPECT_THAT(message([&] { DescriptorSearch({0.1, 0}); }), HasSubstr("at_least is 0"));
}

TEST(DescriptorSearch, WithAShareOfOneEqualsBruteForce) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto landmarks = clustered_features(seed, 200 * seed), queries = clustered_features(seed + 50, 61);
    DescriptorIndex index;
    std::map<int, Feature> map;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const int id = int(3 * i + 1);
      map[id] = landmarks[i];
      index.insert(id, landmarks[i].descriptor, landmarks[i].laplacian);
    }
    for (const InstructionSet set : {InstructionSet::portable, InstructionSet::sse2, InstructionSet::avx2}) {
      if (!has(set)) continue;
      DescriptorSearch search({1, 1}, set);
      const auto& found = search.nearest(queries, index);
      ASSERT_EQ(found.size(), queries.size());
      for (std::size_t q = 0; q < queries.size(); ++q)
        expect_same(found[q], exact_neighbours(queries[q], map), "seed " + std::to_string(seed));
    }
  }
}

TEST(DescriptorSearch, AmongChosenIdsIsExactAndIgnoresTheOthers) {
  const auto landmarks = clustered_features(1, 3000), queries = clustered_features(2, 50);
  DescriptorIndex index;
  std::map<int, Feature> chosen;
  std::vector<int> ids;
  for (int i = 0; i < int(landmarks.size()); ++i) {
    const Feature& f = landmarks[std::size_t(i)];
    index.insert(i, f.descriptor, f.laplacian);
    if (i % 7) continue;
    chosen[i] = f;
    ids.insert(ids.begin() + (i % 2 ? 0 : int(ids.size())), i);  // in any order
    ids.push_back(i);                                            // and twice
  }
  DescriptorSearch search;
  const auto& found = search.nearest(queries, index, ids);
  for (std::size_t q = 0; q < queries.size(); ++q)
    expect_same(found[q], exact_neighbours(queries[q], chosen), "query " + std::to_string(q));
  for (const Neighbours& n : search.nearest(queries, index, {})) EXPECT_EQ(n[0].id, -1);
}

TEST(DescriptorSearch, WithoutSomeIdsIsExactAmongTheOthers) {
  const auto landmarks = clustered_features(1, 3000), queries = clustered_features(2, 50);
  DescriptorIndex index;
  std::map<int, Feature> all, others;
  std::vector<bool> left_out(2900);  // those beyond its end count
  for (int i = 0; i < int(landmarks.size()); ++i) {
    const Feature& f = landmarks[std::size_t(i)];
    index.insert(i, f.descriptor, f.laplacian);
    all[i] = f;
    if (i < int(left_out.size()) && i % 3 > 0)
      left_out[std::size_t(i)] = true;
    else
      others[i] = f;
  }
  DescriptorSearch search({1, 1});
  const auto& found = search.nearest_without(left_out, queries, index);
  for (std::size_t q = 0; q < queries.size(); ++q)
    expect_same(found[q], exact_neighbours(queries[q], others), "query " + std::to_string(q));
  const auto& again = search.nearest(queries, index);
  for (std::size_t q = 0; q < queries.size(); ++q)
    expect_same(again[q], exact_neighbours(queries[q], all), "of all, query " + std::to_string(q));
}

TEST(DescriptorSearch, MatchesAreThoseOfTheMatcher) {
  Random random(5);
  const auto landmarks = clustered_features(3, 900);
  auto queries = clustered_features(4, 300);
  for (std::size_t q = 0; q < queries.size(); q += 2) {  // observations of landmarks, some twice
    queries[q] = landmarks[random.below(150)];
    for (auto& byte : queries[q].descriptor) byte = std::uint8_t(byte + random.below(7));
  }
  DescriptorIndex index;
  for (int i = 0; i < int(landmarks.size()); ++i)
    index.insert(i, landmarks[std::size_t(i)].descriptor, landmarks[std::size_t(i)].laplacian);
  const auto expected = match(queries, landmarks);
  ASSERT_GT(expected.size(), 50u);
  DescriptorSearch search({1, 1});
  std::vector<int> all(landmarks.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = int(i);
  for (const auto& found : {search.match(queries, index), search.match(queries, index, all)}) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].a, expected[i].a);
      EXPECT_EQ(found[i].b, expected[i].b);
      EXPECT_EQ(found[i].distance2, expected[i].distance2);
    }
  }
}

TEST(DescriptorSearch, AnEmptyIndexOrFrameHasNoNeighbours) {
  DescriptorIndex index;
  DescriptorSearch search;
  for (const Neighbours& n : search.nearest(clustered_features(1, 5), index)) EXPECT_EQ(n[0].id, -1);
  EXPECT_TRUE(search.match(clustered_features(1, 5), index).empty());
  index.insert(0, clustered_features(2, 1)[0].descriptor, 1);
  EXPECT_TRUE(search.nearest({}, index).empty());
}

TEST(DescriptorSearch, AllocatesNothingOnceWarm) {
  const auto landmarks = clustered_features(1, 5000), queries = clustered_features(2, 300);
  DescriptorIndex index;
  for (int i = 0; i < 5000; ++i)
    index.insert(i, landmarks[std::size_t(i)].descriptor, landmarks[std::size_t(i)].laplacian);
  DescriptorSearch search;
  search.match(queries, index);
  const long before = heap_allocations();
  search.match(queries, index);
  EXPECT_EQ(heap_allocations(), before);
}

TEST(DescriptorSearch, FindsNearlyAllNeighboursAmongRecordedDescriptors) {
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  const auto frames = recorded_features(recording_path("tum_fr1_rpy/rgb"), 9);
  const auto map = merged_map(frames, 20000);
  ASSERT_GT(map.size(), 8000u);
  DescriptorIndex index;
  for (int i = 0; i < int(map.size()); ++i)
    index.insert(i, map[std::size_t(i)].descriptor, map[std::size_t(i)].laplacian);
  DescriptorSearch search, exact({1, 1});
  Recall recall;
  std::size_t matches = 0, exact_matches = 0;
  for (const auto& queries : unseen_queries(frames, 4, 500)) {
    recall.add(search.nearest(queries, index), exact.nearest(queries, index));
    matches += search.match(queries, index).size();
    exact_matches += exact.match(queries, index).size();
  }
  std::printf(
      "[          ] nearest and second nearest of %.3f, nearest of %.3f of %zu queries among %zu; "
      "%zu matches, %zu by brute force; %.2f MB\n",
      recall.of_both(), recall.of_nearest(), recall.queries, map.size(), matches, exact_matches,
      double(index.memory_bytes()) / 1e6);
  EXPECT_GE(recall.of_both(), 0.95);
}

}  // namespace
}  // namespace lcmslam

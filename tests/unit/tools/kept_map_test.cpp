// What the study of kills calls lost: keyframes and landmarks that were told and are not in the map's file.

#include "tools/study/faults/kept_map.hpp"

#include <gtest/gtest.h>

#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/messages/graph_samples.hpp"

namespace lcmslam {
namespace {

constexpr std::int64_t mapper = 5, stranger = 99;

graph_t whole_graph(std::int64_t seq, const std::vector<std::int32_t>& ids) {
  std::vector<graph_node_t> nodes;
  for (const std::int32_t id : ids) nodes.push_back(testing::node(id, id));
  return testing::graph_of(seq, nodes, {});
}

graph_t changed_graph(std::int64_t seq, const std::vector<std::int32_t>& ids,
                      const std::vector<std::int32_t>& gone) {
  graph_t m = whole_graph(seq, ids);
  m.change = 1;
  m.gone = gone;
  m.n_gone = static_cast<std::int32_t>(gone.size());
  return m;
}

/// A file with keyframes 0 to 2 and landmarks 0 to 3, of one mapper each, and who hears what both tell.
class KeptMapTest : public ::testing::Test {
 protected:
  KeptMapTest() {
    MapStore store(file());
    Transaction transaction = store.begin();
    const std::int64_t run = store.add_run({"1.2", ""});
    SessionChanges dense, sparse;
    for (int id = 0; id < 3; ++id) dense.put_keyframe(some_keyframe(id), std::nullopt);
    for (int id = 0; id < 4; ++id) sparse.put_landmark(some_landmark(1, id));
    store.write(store.add_session(run, session_of("icp", mapper)), dense);
    store.write(store.add_session(run, session_of("fastslam", mapper)), sparse);
    transaction.commit();
    told_.listen(inputs_);
    for (const char* channel : {"ICP_POSE", "FASTSLAM_POSE"}) {
      pose_estimate_t pose{};
      pose.sender = mapper;
      pose.frame = "map";
      tell(channel, pose);
    }
  }

  template <class M>
  void tell(const char* channel, const M& message) {
    const std::vector<std::uint8_t> bytes = encode_message(message);
    ASSERT_TRUE(inputs_.deliver(channel, bytes.data(), bytes.size()));
  }
  /// base 0 and tiles of `whole`: all of the map.
  void tell_landmarks(std::int64_t base, std::int64_t revision, const std::vector<std::int64_t>& ids,
                      const std::vector<std::int64_t>& removed = {}) {
    std::vector<Landmark> landmarks;
    for (const std::int64_t id : ids) landmarks.push_back(some_landmark(1, id));
    for (landmarks_t& tile : make_landmark_tiles(1000, revision, base, landmarks, removed)) {
      tile.sender = mapper;
      tile.frame = "map";
      tell("FASTSLAM_LANDMARKS", tile);
    }
  }

  std::filesystem::path file() const { return folder_ / "map.lcmslam"; }
  KeptMap judge() const { return judge_kept_map(file(), told_, {}, Eigen::Isometry3d::Identity()); }
  static void expect(const KeptCount& count, int told, int lost, int unjudged) {
    EXPECT_EQ(count.told, told);
    EXPECT_EQ(count.lost, lost);
    EXPECT_EQ(count.unjudged, unjudged);
  }

  TemporaryFolder folder_;
  Inputs inputs_;
  ToldMaps told_;
};

TEST_F(KeptMapTest, WhatIsNotInTheFileWasLost) {
  tell("ICP_GRAPH", whole_graph(0, {0, 1}));
  tell("ICP_GRAPH", changed_graph(1, {2, 3, 4}, {}));
  tell("ICP_GRAPH", changed_graph(2, {}, {4}));
  expect(judge().keyframes, 4, 1, 0);
  tell_landmarks(0, 1, {0, 1, 2});
  tell_landmarks(1, 2, {3, 7, 8}, {});
  tell_landmarks(2, 3, {}, {8});
  expect(judge().landmarks, 5, 1, 0);
}

// The mapper thins its graph, and the message that says so does not arrive here.
TEST_F(KeptMapTest, WhatAMissedMessageMayHaveTakenAwayIsNotCalledLost) {
  tell("ICP_GRAPH", whole_graph(0, {0, 1, 2, 3, 4, 5, 6, 7, 8}));
  tell("ICP_GRAPH", changed_graph(2, {2}, {}));  // 1 told that 3 to 8 are gone
  expect(judge().keyframes, 9, 0, 6);
  tell("ICP_GRAPH", whole_graph(3, {0, 1, 2}));  // a mapper's last words
  expect(judge().keyframes, 3, 0, 0);
}

TEST_F(KeptMapTest, LandmarksThatAMissedMessageMayHaveTakenAwayAreNotCalledLost) {
  tell_landmarks(0, 1, {0, 1, 2, 8, 9});
  tell_landmarks(2, 3, {3});  // 8 and 9 went with revision 2
  expect(judge().landmarks, 6, 0, 2);
  tell_landmarks(0, 3, {0, 1, 2, 3});  // somebody asked again
  expect(judge().landmarks, 4, 0, 0);
}

// Who resends real messages of the graph under another name has no map.
TEST_F(KeptMapTest, StrangersLoseNothing) {
  tell("ICP_GRAPH", whole_graph(0, {0, 1, 2}));
  graph_t m = whole_graph(0, {0, 1});
  m.sender = stranger;
  tell("ICP_GRAPH", m);
  expect(judge().keyframes, 3, 0, 0);
}

// While the processes are stopped nobody takes what they say.
TEST_F(KeptMapTest, WhatAMapperSaysWhileItStopsIsHeard) {
  LcmBus bus("memq://");
  LcmPublisher publisher(bus.lcm(), mapper, 1'000'000);
  Receiver receiver(bus, inputs_);
  publisher.publish("ICP_GRAPH", whole_graph(0, {0, 1, 2, 3, 4}));
  publisher.publish("ICP_GRAPH", whole_graph(1, {0, 1, 2}));
  hear_out(receiver);
  expect(judge().keyframes, 3, 0, 0);
}

}  // namespace
}  // namespace lcmslam

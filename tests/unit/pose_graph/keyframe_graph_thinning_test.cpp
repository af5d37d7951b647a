// A keyframe graph that gives nodes up: memory stays, loops still close, nodes' numbers follow.

#include <gmock/gmock.h>

#include <lcmslam/pose_graph/keyframe_graph.hpp>
#include "tests/unit/dense_mapper/gallery.hpp"

namespace lcmslam {
namespace {

/// Up and down the gallery with tracking that slides off, as one that keeps few keyframes.
struct LongDrive {
  static constexpr int per_way = 10;
  KeyframeGraph graph;
  Eigen::Isometry3d T_world_map = Eigen::Isometry3d::Identity();
  std::vector<std::size_t> bytes;  // at the end of each way back
  std::size_t most_nodes = 0, most_edges = 0;
  int thinned = 0;

  /// `known`: only the first way along makes keyframes.
  LongDrive(int max_keyframes, int laps, bool known = false) : graph(settings(max_keyframes)) {
    Gallery gallery(4);
    Utime now = one_second;
    for (int i = 0; i <= 2 * per_way * laps; ++i, now += one_second) {
      const int place = i % (2 * per_way);
      const double x = 0.4 * (place <= per_way ? place : 2 * per_way - place);
      T_world_map = T_world_map * se3_exp(twist(0, 0.01, 0.004, 0, 0.004, 0));
      const Eigen::Isometry3d T(Eigen::Translation3d(x, 0, 0));
      graph.add(now, T_world_map * T, 1e-6 * Matrix6d::Identity(), gallery.seen_from(T),
                known ? i <= per_way : i % 2 == 0 || i < 20);
      for (const Utime later : {now, now + one_second / 2, now + 3 * one_second / 4}) {
        take(graph.work(later));
        if (const auto gone = graph.thin({})) {
          ++thinned;
          EXPECT_EQ(gone->gone.size(), gone->index.size());
          EXPECT_THAT(gone->gone, testing::Contains(true)) << "nobody need hear of nothing";
        }
      }
      most_nodes = std::max(most_nodes, graph.nodes().size());
      most_edges = std::max(most_edges, graph.edges().size());
      if (place == 0) bytes.push_back(graph.memory_bytes());
    }
    take(graph.finish());
  }

  static KeyframeGraphSettings settings(int max_keyframes) {
    KeyframeGraphSettings s;
    s.max_keyframes = max_keyframes;
    return s;
  }
  void take(const std::optional<KeyframeGraph::Correction>& correction) {
    if (!correction) return;
    graph.apply(*correction);
    T_world_map = correction->back() * T_world_map;
  }
  double error_of_the_return() const {
    return (graph.nodes().front().T_world_camera.translation() -
            graph.nodes().back().T_world_camera.translation())
        .norm();
  }
};

// A node waits for its features while others go: whom it shows has another number then.
TEST(KeyframeGraphThinning, WhatANewNodeShowsIsCalledByItsNewNumber) {
  KeyframeGraphSettings settings;
  settings.max_keyframes = 20;
  KeyframeGraph graph(settings);
  Gallery gallery(4);
  constexpr int shown = 18, last = 40;
  Utime now = one_second;
  for (int i = 0; i <= last; ++i, now += one_second) {
    // Along and back, then aslant from aside.
    const double x = 0.2 * (i <= 20 ? i : 40 - i);
    const Eigen::Isometry3d T =
        i < last ? Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0))
                 : se3_exp(twist(0, 0, 0, 0, -0.75, 0)).pretranslate(Eigen::Vector3d(0.2 * shown + 2, 0, 0));
    KeyframeView view = gallery.seen_from(T);
    if (i < last && i != shown) view = KeyframeView();  // nothing to compare with
    if (i == last) {
      view.features = {};
      view.shows = {shown};
    }
    graph.add(now, T, 1e-3 * Matrix6d::Identity(), std::move(view), i <= 20 || i == last);
    if (i < last) {
      EXPECT_FALSE(graph.work(now + one_second / 2));
      EXPECT_FALSE(graph.work(now + 19 * one_second / 20));
    }
  }
  const auto thinned = graph.thin({});
  ASSERT_TRUE(thinned);
  const int number = thinned->index[shown];
  ASSERT_NE(number, shown);
  if (const auto correction = graph.finish()) graph.apply(*correction);
  const auto loop = std::find_if(graph.edges().begin(), graph.edges().end(),
                                 [](const GraphEdge& e) { return e.kind == EdgeKind::loop; });
  ASSERT_NE(loop, graph.edges().end());
  EXPECT_EQ(loop->from, number);
  EXPECT_EQ(loop->to, static_cast<int>(graph.nodes().size()) - 1);
}

// What waits to be compared stays: where all do, nothing goes, and nobody hears of it.
TEST(KeyframeGraphThinning, NothingIsToldWhereNothingMayGo) {
  KeyframeGraphSettings settings;
  settings.max_keyframes = 5;
  KeyframeGraph graph(settings);
  for (int i = 0; i < 8; ++i)
    graph.add(one_second + 1000 * i, Eigen::Isometry3d(Eigen::Translation3d(0.3 * i, 0, 0)),
              1e-3 * Matrix6d::Identity(), KeyframeView(), true);
  EXPECT_FALSE(graph.thin({}));
  EXPECT_EQ(graph.nodes().size(), 8U);
}

TEST(LongDrive, MemorySettlesAndTheLoopStillCloses) {
  constexpr int laps = 12;
  const LongDrive drive(20, laps), everything(100000, 4);
  EXPECT_EQ(everything.thinned, 0);
  EXPECT_GT(drive.thinned, 5);
  EXPECT_LE(drive.most_nodes, 42U);
  ASSERT_EQ(drive.bytes.size(), laps + 1U);
  const auto half = drive.bytes.begin() + laps / 2;
  const std::size_t early = *std::max_element(drive.bytes.begin() + 3, half),
                    late = *std::max_element(half, drive.bytes.end());
  std::cout << "bytes " << early << " then " << late << ", with everything " << everything.bytes.back()
            << ", edges " << drive.most_edges << ", return " << drive.error_of_the_return() << " ("
            << everything.error_of_the_return() << ")\n";
  EXPECT_LT(static_cast<double>(late), 1.1 * static_cast<double>(early));
  EXPECT_LT(late, everything.bytes.back());
  EXPECT_LT(drive.error_of_the_return(), 0.02);  // each lap alone slides by 0.2 m
  EXPECT_LT(drive.most_edges, 42U * 8);
  // The first node stays, and what is left is in order of time, each with its own id.
  EXPECT_EQ(drive.graph.nodes().front().id, 0);
  for (std::size_t i = 1; i < drive.graph.nodes().size(); ++i)
    EXPECT_LT(drive.graph.nodes()[i - 1].id, drive.graph.nodes()[i].id);
  EXPECT_EQ(drive.graph.nodes().back().id, 2 * LongDrive::per_way * laps);
}

TEST(LongDrive, TheFewestKeyframesThatMayBeAskedForAreKept) {
  const LongDrive drive(5, 4);
  const auto keyframes = std::count_if(drive.graph.nodes().begin(), drive.graph.nodes().end(),
                                       [](const KeyframeGraph::Node& n) { return n.keyframe; });
  EXPECT_LE(keyframes, 5);
  EXPECT_GE(keyframes, 4);
}

// Far from the bound on keyframes: a place that is visited again makes none.
TEST(LongDrive, TheGraphOfAKnownPlaceSettles) {
  const LongDrive drive(100000, 8, true);
  EXPECT_GT(drive.thinned, 5);
  EXPECT_LE(drive.most_nodes, 11U + 50 + 3);  // as work may be under way
  EXPECT_LE(drive.most_edges, 64U * 5);
  const auto keyframes = std::count_if(drive.graph.nodes().begin(), drive.graph.nodes().end(),
                                       [](const KeyframeGraph::Node& n) { return n.keyframe; });
  EXPECT_EQ(keyframes, 11);
  EXPECT_LT(drive.error_of_the_return(), 0.02);
  const std::size_t half = drive.bytes.size() / 2;
  EXPECT_LT(static_cast<double>(drive.bytes.back()), 1.1 * static_cast<double>(drive.bytes[half]));
}

TEST(LongDrive, IsTheSameEachTime) {
  const LongDrive a(20, 4), b(20, 4);
  ASSERT_EQ(a.graph.nodes().size(), b.graph.nodes().size());
  for (std::size_t i = 0; i < a.graph.nodes().size(); ++i) {
    EXPECT_EQ(a.graph.nodes()[i].id, b.graph.nodes()[i].id);
    EXPECT_EQ(a.graph.nodes()[i].T_world_camera.matrix(), b.graph.nodes()[i].T_world_camera.matrix());
  }
}

}  // namespace
}  // namespace lcmslam

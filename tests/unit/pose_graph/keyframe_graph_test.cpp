#include <lcmslam/pose_graph/keyframe_graph.hpp>

#include <gtest/gtest.h>

#include "tests/unit/dense_mapper/gallery.hpp"

namespace lcmslam {
namespace {

/// Along the gallery and back, 0.4 m a node, with tracking that slides off to the side and turns. The map's
/// frame has nothing to do with the gallery's.
struct Visit {
  std::vector<Eigen::Isometry3d> truth;
  KeyframeGraph graph;
  int corrections = 0;

  explicit Visit(const KeyframeGraphSettings& settings = {}, bool neighbours_found = true) : graph(settings) {
    Gallery gallery(4);
    Eigen::Isometry3d T_world_map = se3_exp(twist(5, -3, 1, 0.4, 0.3, 2));
    Utime now = one_second;
    for (int i = 0; i <= 20; ++i, now += one_second) {
      truth.emplace_back(Eigen::Translation3d(i <= 10 ? 0.4 * i : 0.4 * (20 - i), 0, 0));
      T_world_map = T_world_map * se3_exp(twist(0, 0.01, 0.004, 0, 0.004, 0));
      KeyframeView view = gallery.seen_from(truth.back());
      if (!neighbours_found) view = KeyframeView();  // neither features nor points
      graph.add(now, T_world_map * truth.back(), 1e-6 * Matrix6d::Identity(), view, i <= 10);
      take(graph.work(now), T_world_map);
      take(graph.work(now + one_second / 2), T_world_map);
    }
    take(graph.finish(), T_world_map);
  }

  // What tracking carries on moves with the newest node.
  void take(const std::optional<KeyframeGraph::Correction>& correction, Eigen::Isometry3d& T_world_map) {
    if (!correction) return;
    ++corrections;
    graph.apply(*correction);
    T_world_map = correction->back() * T_world_map;
  }

  double error_of_the_return() const {
    const Eigen::Isometry3d& first = graph.nodes().front().T_world_camera;
    const Eigen::Isometry3d& last = graph.nodes().back().T_world_camera;
    return (first.translation() - last.translation()).norm();
  }
};

TEST(KeyframeGraph, ClosesTheLoopOfAReturn) {
  KeyframeGraphSettings without;
  without.enabled = false;
  const Visit drifted(without);
  ASSERT_GT(drifted.error_of_the_return(), 0.1);
  EXPECT_EQ(drifted.corrections, 0);
  const Visit visit;
  EXPECT_GE(visit.corrections, 1);
  EXPECT_LT(visit.error_of_the_return(), 0.01);
  int loops = 0, odometry = 0;
  for (const GraphEdge& e : visit.graph.edges()) {
    loops += e.kind == EdgeKind::loop ? 1 : 0;
    odometry += e.kind == EdgeKind::odometry ? 1 : 0;
    EXPECT_LT(e.from, e.to);
  }
  EXPECT_GE(loops, 3);
  EXPECT_EQ(odometry, 20);
}

/// A path that bends aside; only its ends, which are one place, show something.
struct LoopAtTheEnd {
  std::vector<Eigen::Isometry3d> truth;
  KeyframeGraph graph{{}};
  FeatureFrame last_features;
  Utime now = one_second;

  LoopAtTheEnd() {
    Gallery gallery(4);
    Eigen::Isometry3d T_world_map = Eigen::Isometry3d::Identity();
    for (int i = 0; i <= 20; ++i, now += one_second) {
      truth.emplace_back(Eigen::Translation3d(i <= 10 ? 0.4 * i : 0.4 * (20 - i), 0, 0));
      T_world_map = T_world_map * se3_exp(twist(0, 0.01, 0.004, 0, 0.004, 0));
      const bool end = i % 20 == 0;
      const KeyframeView view = end ? gallery.seen_from(truth.back()) : KeyframeView();
      last_features = view.features;
      graph.add(now, T_world_map * truth.back(), 1e-4 * Matrix6d::Identity(), view, i <= 10);
      if (i < 20) {
        EXPECT_FALSE(graph.work(now));
        EXPECT_FALSE(graph.work(now + one_second / 2));
      }
    }
    now -= one_second;
  }
  double error_of_the_return() const {
    return (graph.nodes().front().T_world_camera.translation() -
            graph.nodes().back().T_world_camera.translation())
        .norm();
  }
};

TEST(KeyframeGraph, ALoopThatIsStillWorkedOnAtTheEndCounts) {
  LoopAtTheEnd visit;
  ASSERT_GT(visit.error_of_the_return(), 0.1);
  EXPECT_FALSE(visit.graph.work(visit.now));         // takes what was done before
  EXPECT_FALSE(visit.graph.work(visit.now + 1000));  // begins
  ASSERT_FALSE(visit.graph.add_features(20, visit.last_features)) << "the work has begun";
  EXPECT_FALSE(visit.graph.ties({20})) << "odometry alone";
  EXPECT_FALSE(visit.graph.ties({5, 20})) << "what is tied is the part before";
  const auto correction = visit.graph.finish();
  ASSERT_TRUE(correction);
  visit.graph.apply(*correction);
  EXPECT_LT(visit.error_of_the_return(), 0.02);
  EXPECT_EQ(visit.graph.edges().back().kind, EdgeKind::loop);
  EXPECT_TRUE(visit.graph.ties({20}));
  EXPECT_TRUE(visit.graph.ties({10})) << "over the loop";
  EXPECT_TRUE(visit.graph.ties({12, 15}));
  EXPECT_FALSE(visit.graph.ties({21})) << "nobody is there";
}

/// Away along the gallery with tracking that says how badly it knows the way, and a last look back at where
/// it began, aslant from two metres aside and without features: nothing is near, nothing is recognised.
struct LookBack {
  KeyframeGraph graph;
  static constexpr int last = 15;

  LookBack(double sigma, const std::vector<int>& shows, const KeyframeGraphSettings& settings = {})
      : graph(settings) {
    Gallery gallery(4);
    Utime now = one_second;
    for (int i = 0; i <= last; ++i, now += one_second) {
      const Eigen::Isometry3d T =
          i < last ? Eigen::Isometry3d(Eigen::Translation3d(0.4 * i, 0, 0))
                   : se3_exp(twist(0, 0, 0, 0, -0.75, 0)).pretranslate(Eigen::Vector3d(2, 0, 0));
      KeyframeView view = gallery.seen_from(T);
      if (i == last) {
        view.features = {};
        view.shows = shows;
      }
      graph.add(now, T, sigma * sigma * Matrix6d::Identity(), std::move(view), true);
      if (const auto correction = graph.work(now)) graph.apply(*correction);
      if (const auto correction = graph.work(now + one_second / 2)) graph.apply(*correction);
    }
    if (const auto correction = graph.finish()) graph.apply(*correction);
  }

  std::vector<int> compared_with() const {
    std::vector<int> nodes;
    for (const GraphEdge& e : graph.edges())
      if (e.kind == EdgeKind::loop && e.to == last) nodes.push_back(e.from);
    return nodes;
  }
};

TEST(KeyframeGraph, WhatShowsOldSurfacesIsComparedFromAnySide) {
  constexpr double vague = 0.03, sure = 1e-4;  // m and rad, of a step
  EXPECT_EQ(LookBack(vague, {0}).compared_with(), std::vector<int>{0});
  EXPECT_EQ(LookBack(vague, {}).compared_with(), std::vector<int>{});
  EXPECT_EQ(LookBack(vague, {14, 10}).compared_with(), std::vector<int>{}) << "they are not old";
  EXPECT_EQ(LookBack(vague, {1, 0, 2}).compared_with(), (std::vector<int>{1, 0})) << "two, of most first";
  EXPECT_EQ(LookBack(vague, {1, 1, 0}).compared_with(), (std::vector<int>{1, 0})) << "each once";
  KeyframeGraphSettings settings;
  settings.floor_translation = settings.floor_rotation = sure;
  EXPECT_EQ(LookBack(sure, {0}, settings).compared_with(), std::vector<int>{}) << "the graph knows better";
}

// Done, but so small that the map was not deformed for it.
TEST(KeyframeGraph, ACorrectionTooSmallForTheMapCountsAtTheEnd) {
  KeyframeGraphSettings settings;
  settings.min_translation = 10;  // m, and rad: all of them
  settings.min_rotation = 3.1;
  const Visit visit(settings);
  EXPECT_EQ(visit.corrections, 1);
  EXPECT_LT(visit.error_of_the_return(), 0.01);
}

TEST(KeyframeGraph, WithoutAnythingSeenItKeepsThePath) {
  const Visit blind({}, false);
  EXPECT_EQ(blind.corrections, 0);
  EXPECT_EQ(blind.graph.edges().size(), 20U);
  EXPECT_GT(blind.error_of_the_return(), 0.1);
}

TEST(KeyframeGraph, DoesNotDependOnHowFastTheWorkIs) {
  const Visit a, b;
  ASSERT_EQ(a.graph.nodes().size(), b.graph.nodes().size());
  for (std::size_t i = 0; i < a.graph.nodes().size(); ++i)
    EXPECT_EQ(a.graph.nodes()[i].T_world_camera.matrix(), b.graph.nodes()[i].T_world_camera.matrix());
}

// It stands where it shows what has been seen from there; how it came there is not known.
TEST(KeyframeGraph, ThePathOfWhoIsFoundAgainGoesOnFromWhatItShows) {
  for (const bool shows_any : {true, false}) {
    KeyframeGraph graph({});
    const auto place = [](int i) { return Eigen::Isometry3d(Eigen::Translation3d(0.4 * i, 0, 0)); };
    for (int i = 0; i <= 8; ++i) graph.add(i, place(i), 1e-4 * Matrix6d::Identity(), {}, true);
    KeyframeView view;
    if (shows_any) view.shows = {1, 0};
    graph.add(9, place(1), 1e-6 * Matrix6d::Identity(), view, false, Floor::plane,
              KeyframeGraph::PlacedBy::relocalisation);
    const GraphEdge& way = graph.edges().back();
    EXPECT_EQ(way.from, shows_any ? 1 : 8);
    EXPECT_EQ(way.to, 9);
    const auto variance = [&](std::size_t node) { return graph.nodes()[node].error.covariance()(0, 0); };
    if (!shows_any) continue;
    EXPECT_LT(variance(9), 0.5 * variance(8)) << "as sure as what it shows";
    EXPECT_GT(variance(9), variance(1));
    EXPECT_LT(way.T_from_to.T.translation().norm(), 1e-9);
  }
}

// An edge over a way that odometry alone knows is no tie, whichever kind it is of.
TEST(KeyframeGraph, AnEdgeThatKnowsNothingTiesNothing) {
  KeyframeGraphSettings settings;
  EXPECT_TRUE(Visit(settings).graph.ties({10}));
  settings.loops.floor_translation = 1;
  EXPECT_FALSE(Visit(settings).graph.ties({10}));
}

TEST(KeyframeGraph, FeaturesMayComeLater) {
  Gallery gallery(4);
  KeyframeView view = gallery.seen_from(Eigen::Isometry3d::Identity());
  const FeatureFrame features = view.features;
  view.features = {};
  KeyframeGraph graph({});
  const int id = graph.add(one_second, Eigen::Isometry3d::Identity(), Matrix6d::Identity(), view, true);
  EXPECT_FALSE(graph.work(one_second + 1000));  // waits for them
  EXPECT_TRUE(graph.add_features(id, features));
  EXPECT_FALSE(graph.work(one_second + 2000));  // begins
  EXPECT_FALSE(graph.add_features(id, features));
  EXPECT_FALSE(graph.add_features(7, features));
}

}  // namespace
}  // namespace lcmslam

#include <lcmslam/configuration/read_settings.hpp>

#include <gmock/gmock.h>

#include "tests/unit/configuration/error_of.hpp"

namespace lcmslam {
namespace {

enum class Metric { point, plane };
constexpr Choice<Metric> metric_names[] = {{"point", Metric::point}, {"plane", Metric::plane}};

struct Filter {
  double min_range = 0.3, max_range = 6;

  void describe(SettingsVisitor& s) {
    s.number("min_range", min_range, "m", {0, 1000}, "nearest distance that is used");
    s.number("max_range", max_range, "m", {0, 1000}, "farthest distance that is used");
    s.require(min_range <= max_range, "max_range", "must not be below min_range");
  }
};

struct Source {
  std::string folder;
  void describe(SettingsVisitor& s) { s.required("folder", folder, "that holds the images"); }
};

struct Mapper {
  int points = 200;
  double share = 0.5;
  std::uint64_t seed = 1;
  bool enabled = true, live = true;
  Metric metric = Metric::plane;
  std::string channel = "POSE", source = "none";
  std::vector<std::string> parts = {"speckle"};
  std::vector<double> weights = {1, 2};
  Filter filter;
  Source data;

  void describe(SettingsVisitor& s) {
    s.number("points", points, "", {1, 1e6}, "points that are kept");
    s.number("share", share, "", {0, 1}, "of them");
    s.number("seed", seed, "", {0, 2147483647}, "of the draws");
    s.flag("enabled", enabled, "whether it runs");
    s.choice("metric", metric, metric_names, "what is minimised");
    s.text("channel", channel, "that is listened to");
    s.choice("source", source, {"none", "data"}, "of the images");
    s.texts("parts", parts, "in order", {"speckle", "jump_edges"});
    s.numbers("weights", weights, "kg", {0, 10}, "of the wheels");
    s.section("filter", filter, "which points enter");
    s.alternative(source == "data", "data", data, "where the source is data");
    s.require(!live || filter.max_range < 500, "filter.max_range", "must be below 500 where it is live");
  }
};

ConfigNode read_text(const std::string& text) {
  return ConfigNode::parse(text, "icp.yaml");
}

Mapper read(const std::string& text) {
  const ConfigNode config = read_text(text);
  Mapper mapper = read_settings<Mapper>(config);
  config.finish();
  return mapper;
}

std::string error(const std::string& text) {
  return error_of([&] { read(text); });
}

TEST(ReadSettings, EveryKindArrives) {
  const Mapper m = read(
      "points: 7\nshare: 0.25\nseed: 9\nenabled: false\nmetric: point\nchannel: BODY\nsource: data\n"
      "parts: [jump_edges, speckle]\nweights: [3]\nfilter: {min_range: 1, max_range: 2.5}\ndata: {folder: "
      "x}\n");
  EXPECT_EQ(m.points, 7);
  EXPECT_EQ(m.share, 0.25);
  EXPECT_EQ(m.seed, 9U);
  EXPECT_FALSE(m.enabled);
  EXPECT_EQ(m.metric, Metric::point);
  EXPECT_EQ(m.channel, "BODY");
  EXPECT_THAT(m.parts, ::testing::ElementsAre("jump_edges", "speckle"));
  EXPECT_THAT(m.weights, ::testing::ElementsAre(3));
  EXPECT_EQ(m.filter.min_range, 1);
  EXPECT_EQ(m.filter.max_range, 2.5);
  EXPECT_EQ(m.data.folder, "x");
}

TEST(ReadSettings, KeysThatAreAbsentKeepTheDefaultsOfTheCaller) {
  Mapper defaults;
  defaults.points = 3;
  defaults.seed = (std::uint64_t{1} << 60) + 1;
  const Mapper m = read_settings(read_text("{enabled: false}"), defaults);
  EXPECT_EQ(m.points, 3);
  EXPECT_EQ(m.seed, defaults.seed);
  EXPECT_EQ(m.metric, Metric::plane);
  EXPECT_FALSE(m.enabled);
}

TEST(ReadSettings, WrongValuesNameFileLineAndWhatWouldBeRight) {
  EXPECT_EQ(error("seed: 1\npoints: 0\n"),
            "icp.yaml:2: 'points' must be a whole number from 1 to 1000000, got '0'");
  EXPECT_EQ(error("points: 1.5\n"),
            "icp.yaml:1: 'points' must be a whole number from 1 to 1000000, got '1.5'");
  EXPECT_EQ(error("filter:\n  max_range: -1\n"),
            "icp.yaml:2: 'max_range' must be a number from 0 to 1000, got '-1'");
  EXPECT_EQ(error("metric: sphere\n"), "icp.yaml:1: 'metric' must be one of 'point', 'plane', got 'sphere'");
  EXPECT_EQ(error("enabled: 3\n"), "icp.yaml:1: 'enabled' must be true or false, got '3'");
  EXPECT_EQ(error("parts: [median]\n"),
            "icp.yaml:1: 'parts' must be a list, each one of 'speckle', 'jump_edges', got 'median'");
  EXPECT_EQ(error("weights: [11]\n"),
            "icp.yaml:1: 'weights' must be a list, each a number from 0 to 10, got 11");
  EXPECT_EQ(error("filter: 3\n"), "icp.yaml:1: 'filter' must be a mapping, got '3'");
}

TEST(ReadSettings, RequirementsNameTheLineOfTheirKey) {
  EXPECT_EQ(error("filter:\n  min_range: 1\n  max_range: 0.5\n"),
            "icp.yaml:3: 'max_range' must not be below min_range");
  EXPECT_EQ(error("\nfilter:\n\n  max_range: 600\n"),
            "icp.yaml:4: 'filter.max_range' must be below 500 where it is live");
  // The key itself is absent: its section.
  EXPECT_EQ(error("\nfilter:\n  min_range: 7\n"), "icp.yaml:2: 'max_range' must not be below min_range");
}

TEST(ReadSettings, UnknownKeysNameTheNearest) {
  EXPECT_EQ(error("filter: {max_rnge: 1}\n"),
            "icp.yaml:1: unknown key 'max_rnge' in 'filter' (did you mean 'max_range'?)");
}

TEST(ReadSettings, AlternativesThatAreNotChosenAreNotLookedAt) {
  EXPECT_EQ(error("data: {any: thing}\n"), "no error");
  EXPECT_EQ(error("source: data\ndata: {folder: x, any: thing}\n"),
            "icp.yaml:2: unknown key 'any' in 'data' (did you mean 'folder'?)");
}

TEST(ReadSettings, WhatIsRequiredMustStandInTheFile) {
  EXPECT_EQ(error("source: data\ndata: {foldr: x}\n"),
            "icp.yaml:2: required key 'folder' is missing in 'data' (is 'foldr' meant to be it?)");
}

}  // namespace
}  // namespace lcmslam

#include <lcmslam/settings/check.hpp>

#include <gmock/gmock.h>

#include <cmath>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

enum class Metric { point, plane };
constexpr Choice<Metric> metric_names[] = {{"point_to_point", Metric::point},
                                           {"point_to_plane", Metric::plane}};

struct Filter {
  double min_range = 0.3;
  double max_range = 6;

  void describe(SettingsVisitor& s) {
    s.number("min_range", min_range, "m", {0, 1000}, "nearest distance that is used");
    s.number("max_range", max_range, "m", {0, 1000}, "farthest distance that is used");
    s.require(min_range <= max_range, "max_range", "must not be below min_range");
  }
};

struct Mapper {
  int points = 200;
  double share = 0.1;
  std::uint64_t seed = 1;
  bool enabled = true;
  Metric metric = Metric::plane;
  std::string channel = "POSE_BODY", shape = "round", file = "map.db";
  std::vector<std::string> parts = {"speckle"};
  std::vector<double> weights = {1, 0.5};
  Filter filter, other;

  void describe(SettingsVisitor& s) {
    s.number("points", points, "", {1, 1e6}, "points that are kept");
    s.number("share", share, "", {0, 1}, "of them");
    s.number("seed", seed, "", {0, 2147483647}, "of the draws");
    s.flag("enabled", enabled, "whether it runs");
    s.choice("metric", metric, metric_names, "what is minimised");
    s.text("channel", channel, "that is listened to");
    s.choice("shape", shape, {"round", "flat"}, "of the world");
    s.required("file", file, "that is written");
    s.texts("parts", parts, "in order", {"speckle", "jump_edges"});
    s.numbers("weights", weights, "kg", {0, 10}, "of the wheels");
    s.section("filter", filter, "which points enter");
    s.alternative(shape == "flat", "other", other, "of the flat world");
  }
};

std::string error_of(const Mapper& mapper) {
  try {
    check(mapper, "mapper");
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

/// The error after one change.
template <class Change>
std::string with(const Change& change) {
  Mapper mapper;
  change(mapper);
  return error_of(mapper);
}

TEST(Settings, AreListedInTheirOrderWithEverythingThatIsSaidOfThem) {
  const std::vector<SettingEntry> all = list_settings(Mapper());
  std::vector<std::string> lines;
  for (const SettingEntry& e : all)
    lines.push_back(e.path + " = " + e.value + " [" + e.unit + "] " + allowed(e) + (e.required ? "!" : ""));
  EXPECT_THAT(
      lines,
      ElementsAre("points = 200 [] a whole number from 1 to 1000000", "share = 0.1 [] a number from 0 to 1",
                  "seed = 1 [] a whole number from 0 to 2147483647", "enabled = true [] true or false",
                  "metric = point_to_plane [] one of 'point_to_point', 'point_to_plane'",
                  "channel = POSE_BODY [] a text", "shape = round [] one of 'round', 'flat'",
                  "file = map.db [] a text!",
                  "parts = [speckle] [] a list, each one of 'speckle', 'jump_edges'",
                  "weights = [1, 0.5] [kg] a list of numbers from 0 to 10",
                  "filter.min_range = 0.3 [m] a number from 0 to 1000",
                  "filter.max_range = 6 [m] a number from 0 to 1000",
                  "other.min_range = 0.3 [m] a number from 0 to 1000",
                  "other.max_range = 6 [m] a number from 0 to 1000"));
  EXPECT_EQ(all[0].meaning, "points that are kept");
}

TEST(Settings, TextsThatYamlWouldMisreadAreQuoted) {
  Mapper mapper;
  mapper.channel = "";
  mapper.parts = {"a, b", "-1"};
  const auto all = list_settings(mapper);
  EXPECT_EQ(all[5].value, "''");
  EXPECT_EQ(all[8].value, "['a, b', '-1']");
}

TEST(Settings, RightOnesPassTheCheck) {
  EXPECT_EQ(error_of({}), "no error");
}

TEST(Settings, TheCheckNamesTheKeyTheValueAndWhatWouldBeRight) {
  EXPECT_EQ(with([](Mapper& m) { m.points = 0; }),
            "mapper: points is 0, must be a whole number from 1 to 1000000");
  EXPECT_EQ(with([](Mapper& m) { m.filter.max_range = -1; }),
            "mapper: filter.max_range is -1 m, must be a number from 0 to 1000");
  EXPECT_EQ(with([](Mapper& m) { m.filter.max_range = 0.1; }),
            "mapper: filter.max_range is 0.1 m, must not be below min_range");
  EXPECT_EQ(with([](Mapper& m) { m.shape = "hollow"; }),
            "mapper: shape is hollow, must be one of 'round', 'flat'");
  EXPECT_EQ(with([](Mapper& m) { m.file.clear(); }), "mapper: file is '', must be given");
  EXPECT_EQ(with([](Mapper& m) { m.parts.push_back("median"); }),
            "mapper: parts is [speckle, median], must be a list, each one of 'speckle', 'jump_edges'");
  EXPECT_THAT(with([](Mapper& m) { m.metric = static_cast<Metric>(7); }), HasSubstr("metric is"));
  EXPECT_THAT(with([](Mapper& m) { m.weights[1] = 11; }), HasSubstr("weights is [1, 11] kg"));
}

TEST(Settings, WhatIsNoNumberIsOutsideEveryRange) {
  EXPECT_THAT(with([](Mapper& m) { m.filter.min_range = std::nan(""); }), HasSubstr("min_range is nan"));
  EXPECT_THAT(with([](Mapper& m) { m.filter.max_range = INFINITY; }), HasSubstr("max_range is inf"));
}

TEST(Settings, OnlyTheAlternativeThatIsChosenIsChecked) {
  EXPECT_EQ(with([](Mapper& m) { m.other.min_range = -1; }), "no error");
  EXPECT_THAT(with([](Mapper& m) {
                m.other.min_range = -1;
                m.shape = "flat";
              }),
              HasSubstr("other.min_range is -1 m"));
}

TEST(Settings, ListingAndCheckingChangeNothing) {
  struct Seed {
    std::uint64_t seed = (std::uint64_t{1} << 60) + 1;  // no double holds it
    void describe(SettingsVisitor& s) { s.number("seed", seed, "", {0, 1e19}, "of the draws"); }
  } seed;
  SettingsCheck visitor;
  seed.describe(visitor);
  EXPECT_FALSE(visitor.failed());
  EXPECT_EQ(seed.seed, (std::uint64_t{1} << 60) + 1);
}

TEST(Settings, NumbersAreWrittenAsShortAsTheyCanBeReadBack) {
  for (const double number : {0.0, 0.1, 1.0 / 3, 6e6, 1e-5, 1e-300, -2.5e12, 100000.0, 2147483647.0})
    EXPECT_EQ(std::stod(number_text(number)), number);
  EXPECT_EQ(number_text(6e6), "6000000");
  EXPECT_EQ(number_text(0.00873), "0.00873");
  EXPECT_EQ(number_text(1e-5), "1e-05");
}

}  // namespace
}  // namespace lcmslam

#include <lcmslam/configuration/config.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <lcmslam/configuration/nearest_word.hpp>
#include "tests/unit/configuration/error_of.hpp"

namespace lcmslam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const char* const demo = R"(# comment
seed: 7
fastslam:
  particles: 200
  noise: [0.1, 0.2, 0.3]
  proposal: optimal
  planar: true
processes:
  - name: surf
    rate: 30
  - name: icp
empty:
)";

ConfigNode parse(const std::string& text) {
  return ConfigNode::parse(text, "demo.yaml");
}

TEST(Config, ReadsEveryKind) {
  const ConfigNode config = parse(demo);
  EXPECT_EQ(config.get("seed", 1), 7);
  const ConfigNode fastslam = config.section("fastslam");
  EXPECT_EQ(fastslam.get("particles", 100, Range{1, 1000}), 200);
  EXPECT_THAT(fastslam.get("noise", std::vector<double>{}), ElementsAre(0.1, 0.2, 0.3));
  EXPECT_THAT(fastslam.numbers("noise", 3), ElementsAre(0.1, 0.2, 0.3));
  EXPECT_EQ(fastslam.choice("proposal", "motion", {"motion", "optimal"}), "optimal");
  EXPECT_TRUE(fastslam.get("planar", false));
  const std::vector<ConfigNode> processes = config.sections("processes");
  ASSERT_EQ(processes.size(), 2u);
  EXPECT_EQ(processes[0].text("name"), "surf");
  EXPECT_DOUBLE_EQ(processes[0].get("rate", 10.0), 30.0);
  EXPECT_EQ(processes[1].text("name"), "icp");
  EXPECT_THAT(config.section("empty").keys(), ElementsAre());
  EXPECT_NO_THROW(config.finish());
}

TEST(Config, AbsentKeysGiveDefaults) {
  const ConfigNode config;
  EXPECT_DOUBLE_EQ(config.get("a", 2.5), 2.5);
  EXPECT_EQ(config.get("b", 3), 3);
  EXPECT_TRUE(config.get("c", true));
  EXPECT_EQ(config.get("d", "text"), "text");
  EXPECT_THAT(config.get("e", std::vector<std::string>{"x"}), ElementsAre("x"));
  EXPECT_EQ(config.choice("f", "one", {"one", "two"}), "one");
  EXPECT_TRUE(config.sections("g").empty());
  EXPECT_EQ(config.section("h").section("i").get("j", 4), 4);
  EXPECT_NO_THROW(config.finish());
}

TEST(Config, UnknownKeyNamesFileLineAndNearestKey) {
  const ConfigNode config = parse("seed: 1\nfastslam:\n  landmarks: 5\n  partcles: 200\n");
  config.get("seed", 0);
  const ConfigNode fastslam = config.section("fastslam");
  fastslam.get("particles", 1);
  fastslam.get("landmarks", 1);
  EXPECT_EQ(error_of([&] { config.finish(); }),
            "demo.yaml:4: unknown key 'partcles' in 'fastslam' (did you mean 'particles'?)");
}

TEST(NearestWord, IsAFingersSlipAwayOrHoldsWhatWasTypedOrLooksAlike) {
  const std::vector<std::string> keys = {"pose", "map_voxel_size", "voxel_size", "filter"};
  EXPECT_EQ(nearest_word("voxel", keys), "voxel_size");
  EXPECT_EQ(nearest_word("voxel", keys, 2), "voxel_size") << "however much is missing";
  EXPECT_EQ(nearest_word("oxel", keys), "voxel_size") << "the shorter one";
  EXPECT_EQ(nearest_word("filte", {"filtering", "filter"}), "filter");
  EXPECT_EQ(nearest_word("siz", keys), "pose") << "few letters stand in many words";
  EXPECT_EQ(nearest_word("x", {"a"}, 0), "");
  EXPECT_EQ(nearest_word("", {"a"}), "a");
}

TEST(Config, UnknownKeysAreFoundAtTheTopInListsAndInSectionsNobodyAskedFor) {
  const ConfigNode top = parse("sede: 1\n");
  top.get("seed", 0);
  EXPECT_EQ(error_of([&] { top.finish(); }), "demo.yaml:1: unknown key 'sede' (did you mean 'seed'?)");

  const ConfigNode list = parse("list:\n- a: 1\n- a: 1\n  b: 2\n");
  for (const ConfigNode& item : list.sections("list")) item.get("a", 0);
  EXPECT_EQ(error_of([&] { list.finish(); }),
            "demo.yaml:4: unknown key 'b' in 'list[1]' (did you mean 'a'?)");

  const ConfigNode section = parse("icp: {a: 1}\n");
  EXPECT_EQ(error_of([&] { section.finish(); }), "demo.yaml:1: unknown key 'icp'");
}

TEST(Config, AskingWhetherAKeyIsThereDoesNotReadIt) {
  const ConfigNode config = parse("a: 1\n");
  EXPECT_TRUE(config.has("a"));
  EXPECT_FALSE(config.has("b"));
  EXPECT_THROW(config.finish(), ConfigError);
}

TEST(Config, IgnoredKeysNeedNoReader) {
  const ConfigNode config = parse("icp: {a: {b: 1}}\nother: [1, 2]\n");
  config.ignore("icp");
  config.ignore("other");
  config.ignore("absent");
  EXPECT_NO_THROW(config.finish());
}

TEST(Config, CopiesAndRepeatedSectionsShareTheRecord) {
  const ConfigNode config = parse("a: 1\nb: {c: 2, d: 3}\n");
  const ConfigNode copy = config;
  copy.get("a", 0);
  copy.section("b").get("c", 0);
  EXPECT_THAT(error_of([&] { config.finish(); }), HasSubstr("'d' in 'b'"));
  config.section("b").get("d", 0);
  EXPECT_NO_THROW(copy.finish());
}

TEST(Config, WrongKindsNameLineAndValue) {
  const ConfigNode config = parse(
      "particles: many\nrate: fast\nplanar: maybe\nname: [1]\nnoise: 3\nicp: 5\nlist: {a: 1}\n"
      "mixed:\n  - 1\n  - x\nnone:\nkind: clever\n");
  EXPECT_EQ(error_of([&] {
              config.get("particles", 1, Range{1, 100000});
            }),
            "demo.yaml:1: 'particles' must be a whole number from 1 to 100000, got 'many'");
  EXPECT_EQ(error_of([&] {
              config.get("rate", 1.0, Range{0, 1e9});
            }),
            "demo.yaml:2: 'rate' must be a number from 0 to 1000000000, got 'fast'");
  EXPECT_EQ(error_of([&] { config.get("planar", true); }),
            "demo.yaml:3: 'planar' must be true or false, got 'maybe'");
  EXPECT_EQ(error_of([&] { config.get("name", "x"); }), "demo.yaml:4: 'name' must be a text, got a list");
  EXPECT_EQ(error_of([&] { config.numbers("noise", 3); }),
            "demo.yaml:5: 'noise' must be a list of 3 numbers, got '3'");
  EXPECT_EQ(error_of([&] { config.section("icp"); }), "demo.yaml:6: 'icp' must be a mapping, got '5'");
  EXPECT_EQ(error_of([&] { config.sections("list"); }),
            "demo.yaml:7: 'list' must be a list of mappings, got a mapping");
  EXPECT_EQ(error_of([&] { config.get("mixed", std::vector<double>{}); }),
            "demo.yaml:10: 'mixed' must be a list of numbers, got 'x'");
  EXPECT_EQ(error_of([&] { config.get("none", 1); }),
            "demo.yaml:11: 'none' must be a whole number, got nothing");
  EXPECT_EQ(error_of([&] {
              config.choice("kind", "a", {"a", "b"});
            }),
            "demo.yaml:12: 'kind' must be one of 'a', 'b', got 'clever'");
}

TEST(Config, NumbersAreStrict) {
  for (const char* text : {"1.5", "1e2", "0x10", "1 2", "'5'", "99999999999", "", "--1", "+-1", "5m"})
    EXPECT_THROW(parse("a: " + std::string(text)).get("a", 1), ConfigError) << text;
  for (const char* text : {".nan", "nan", ".inf", "inf", "-inf", "1e999", "1,5", "1.5 m", "'1'", "~"})
    EXPECT_THROW(parse("a: " + std::string(text)).get("a", 1.0), ConfigError) << text;
  EXPECT_EQ(parse("a: -12").get("a", 1), -12);
  EXPECT_EQ(parse("a: +12").get("a", 1), 12);
  EXPECT_DOUBLE_EQ(parse("a: -1.5e-3").get("a", 1.0), -1.5e-3);
  EXPECT_DOUBLE_EQ(parse("a: .5").get("a", 1.0), 0.5);
  EXPECT_THROW(parse("a: [1, .nan]").numbers("a", 2), ConfigError);
}

TEST(Config, RangesAreClosedAndDescribed) {
  EXPECT_EQ(parse("a: 1").get("a", 0, Range{1, 3}), 1);
  EXPECT_EQ(parse("a: 3").get("a", 0, Range{1, 3}), 3);
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_THAT(error_of([&] { parse("a: 4").get("a", 0, Range{1, 3}); }), HasSubstr("from 1 to 3, got '4'"));
  EXPECT_THAT(error_of([&] {
                parse("a: -1").get("a", 0.5, Range{0, infinity});
              }),
              HasSubstr("a number of at least 0, got '-1'"));
  EXPECT_THAT(error_of([&] {
                parse("a: 2").number("a", Range{-infinity, 1});
              }),
              HasSubstr("a number of at most 1, got '2'"));
}

TEST(Config, MissingRequiredKeyIsNamed) {
  const ConfigNode config = parse("a: 1\ncalibration:\n  focal_lenght: 1\n");
  EXPECT_EQ(error_of([&] { config.text("name"); }), "demo.yaml: required key 'name' is missing");
  EXPECT_EQ(error_of([&] { config.section("calibration").number("focal_length"); }),
            "demo.yaml:2: required key 'focal_length' is missing in 'calibration' (is 'focal_lenght' meant "
            "to be it?)");
  EXPECT_THAT(error_of([&] { parse("a: [1, 2]").numbers("a", 3); }),
              HasSubstr("'a' must be a list of 3 numbers, got 2"));
}

TEST(Config, TextIsTakenAsItStands) {
  const ConfigNode config = parse("a: 5\nb: 'true'\nc: \"x: y\"\nd: ''\n");
  EXPECT_EQ(config.text("a"), "5");
  EXPECT_EQ(config.text("b"), "true");
  EXPECT_EQ(config.text("c"), "x: y");
  EXPECT_EQ(config.get("d", "fallback"), "");
  EXPECT_THROW(config.get("b", false), ConfigError) << "quoted: a text, not a truth value";
}

TEST(Config, KeysKeepTheFilesOrder) {
  EXPECT_THAT(parse("zebra: 1\nape: 2\nmouse: 3\n").keys(), ElementsAre("zebra", "ape", "mouse"));
}

TEST(Config, OverridesReplaceAddAndNameThemselves) {
  ConfigNode config = parse("icp: {iterations: 10, kind: point}\nseed: 1\n");
  config.set("icp.iterations", "25");
  config.set("icp.overlap.radius", "0.5");
  config.set("seed", "3");
  config.set("list", "[1, 2]");
  EXPECT_EQ(config.section("icp").get("iterations", 0), 25);
  EXPECT_EQ(config.section("icp").text("kind"), "point");
  EXPECT_DOUBLE_EQ(config.section("icp").section("overlap").number("radius"), 0.5);
  EXPECT_EQ(config.get("seed", 0), 3);
  EXPECT_THAT(config.numbers("list", 2), ElementsAre(1, 2));
  EXPECT_NO_THROW(config.finish());

  config.set("icp.iteratons", "5");
  EXPECT_EQ(error_of([&] { config.finish(); }),
            "--set icp.iteratons=5: unknown key 'iteratons' in 'icp' (did you mean 'iterations'?)");
  config.set("seed", "x");
  EXPECT_EQ(error_of([&] { config.get("seed", 0); }), "--set seed=x: 'seed' must be a whole number, got 'x'");
  EXPECT_THROW(config.set("seed.below", "1"), ConfigError);
  EXPECT_THROW(config.set("", "1"), ConfigError);
  EXPECT_THROW(config.set("icp..a", "1"), ConfigError);
  EXPECT_THROW(config.set("icp.a", "[1"), ConfigError);
}

TEST(Config, AWholeSectionCanBeReplaced) {
  ConfigNode config = parse("icp: {iterations: 10}\n");
  EXPECT_EQ(config.section("icp").get("iterations", 0), 10);
  config.set("icp", "{iterations: 11}");
  EXPECT_EQ(config.section("icp").get("iterations", 0), 11);
  config.set("icp.iterations", "12");
  EXPECT_EQ(config.section("icp").get("iterations", 0), 12);
}

TEST(Config, CallersFailWithThePlace) {
  const ConfigNode config = parse("a: 1\nb:\n  c: 2\n");
  EXPECT_EQ(config.where(), "demo.yaml");
  EXPECT_EQ(config.where("b"), "demo.yaml:2");
  EXPECT_EQ(config.section("b").where(), "demo.yaml:2");
  EXPECT_EQ(error_of([&] { config.section("b").fail("c", "is odd"); }), "demo.yaml:3: is odd");
  EXPECT_EQ(ConfigNode::parse("a: 1", "/some/where/x.yaml").folder(), "/some/where");
}

}  // namespace
}  // namespace lcmslam

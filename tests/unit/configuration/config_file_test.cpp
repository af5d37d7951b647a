// Files: syntax errors, includes, and damaged input.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>
#include <fstream>
#include <random>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/configuration/yaml_text.hpp>
#include "tests/unit/configuration/error_of.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class ConfigFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "config_test_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  fs::path folder_;
};

std::string parse_error(const std::string& text) {
  return error_of([&] { ConfigNode::parse(text, "demo.yaml"); });
}

TEST(ConfigSyntax, ErrorsNameTheLine) {
  EXPECT_THAT(parse_error("a: 1\nb: [1, 2\n"), StartsWith("demo.yaml:"));
  EXPECT_THAT(parse_error("a: 1\nb:\n\tc: 2\n"), StartsWith("demo.yaml:3: "));
  EXPECT_THAT(parse_error("a: 1\nb:\n\tc: 2\n"), HasSubstr("no tabs"));
  EXPECT_THAT(parse_error("a: 1\n  b: 2\n"), StartsWith("demo.yaml:2: "));
  EXPECT_THAT(parse_error("- 1\n- 2\n"), HasSubstr("must be a mapping of keys to values, got a list"));
  EXPECT_THAT(parse_error("just text"), HasSubstr("got 'just text'"));
  EXPECT_THAT(parse_error("a: 1\n---\nb: 2\n"), HasSubstr("more than one YAML document"));
  EXPECT_THAT(parse_error("[1, 2]: x\n"), HasSubstr("a key must be a word, got a list"));
  EXPECT_EQ(parse_error(""), "no error");
  EXPECT_EQ(parse_error("# only a comment\n"), "no error");
}

TEST(ConfigSyntax, AByteOfValueZeroIsNoEndOfFile) {
  const auto error = [](const std::string& text) { return parse_error(text); };
  EXPECT_EQ(error(std::string(3, '\0')), "demo.yaml:1: a byte of value 0: must be text in UTF-8");
  EXPECT_EQ(error(std::string("a: 1\nb: 2\n\0c: 3\n", 16)),
            "demo.yaml:3: a byte of value 0: must be text in UTF-8");
}

/// Latin-1, a character cut short, a surrogate, an overlong '/', and what lies behind the last character.
TEST(ConfigSyntax, WhatIsNoUtf8IsRefused) {
  EXPECT_EQ(parse_error("a: 1\nscene: K\xfc"
                        "che\n"),
            "demo.yaml:2: a byte of value 252: must be text in UTF-8");
  for (const char* bytes : {"\xc3", "\xed\xa0\x80", "\xc0\xaf", "\xf4\x90\x80\x80", "\x80"})
    EXPECT_THAT(parse_error(std::string("# ") + bytes + "\n"), HasSubstr("must be text in UTF-8")) << bytes;
  EXPECT_EQ(parse_error("a: \"K\u00fcche \U0001f916\"\n"), "no error");
  ConfigNode config;
  EXPECT_EQ(error_of([&] { config.set("a", "\xff"); }),
            "--set a=\xff:1: a byte of value 255: must be text in UTF-8");
}

TEST(ConfigSyntax, QuotedTextReadsBackAsItWas) {
  std::string all;
  for (char c = 1; c < 127; ++c) all += c;
  for (const std::string& text :
       {all, std::string("/tmp/a\nb"), std::string("/tmp/run #2"), std::string("a: b"),
        std::string("/tmp/K\u00fcche \"1\"\\"), std::string("[x]"), std::string("\x7f")}) {
    ConfigNode config;
    config.set("folder", yaml_quoted(text));
    EXPECT_EQ(config.text("folder"), text);
  }
}

TEST(ConfigSyntax, DuplicateKeysAreFoundAtEveryLevel) {
  EXPECT_EQ(parse_error("a: 1\nb: 2\na: 3\n"), "demo.yaml:3: key 'a' stands twice, first in line 1");
  EXPECT_EQ(parse_error("x:\n  - a: 1\n    b: {c: 1,\n        c: 2}\n"),
            "demo.yaml:4: key 'c' stands twice, first in line 3");
}

TEST(ConfigSyntax, AliasesWorkButCannotExplode) {
  const ConfigNode config = ConfigNode::parse("a: &one {x: 1}\nb: *one\n");
  EXPECT_EQ(config.section("b").get("x", 0), 1);
  EXPECT_THROW(config.finish(), ConfigError) << "a was not read: each place counts for itself";

  EXPECT_THAT(parse_error("a: &a [*a]\n"), HasSubstr("alias"));
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int level = 1; level < 12; ++level) {
    const std::string below = "*a" + std::to_string(level - 1);
    bomb += "a" + std::to_string(level) + ": &a" + std::to_string(level) + " [" + below;
    for (int i = 1; i < 10; ++i) bomb += ", " + below;
    bomb += "]\n";
  }
  EXPECT_THAT(parse_error(bomb), HasSubstr("more than 100000 values"));

  std::string chain = "a0: &a0 {x: 1}\n";
  for (int level = 1; level < 100; ++level)
    chain += "a" + std::to_string(level) + ": &a" + std::to_string(level) + " {x: *a" +
             std::to_string(level - 1) + "}\n";
  EXPECT_THAT(parse_error(chain), HasSubstr("levels deep"));
}

TEST(ConfigSyntax, DeepNestingIsAnError) {
  for (const char* opening : {"[", "{", "- ", "? ", "{a: ", "a: ["})
    for (int depth : {70, 20000}) {
      std::string text = "key: \n  ";
      for (int i = 0; i < depth; ++i) text += opening;
      EXPECT_THAT(parse_error(text), StartsWith("demo.yaml")) << opening << depth;
    }
}

TEST_F(ConfigFile, MissingFileAndFolderAreNamed) {
  EXPECT_EQ(error_of([&] { ConfigNode::load(folder_ / "none.yaml"); }), path("none.yaml") + ": no such file");
  EXPECT_EQ(error_of([&] { ConfigNode::load(folder_); }),
            folder_.string() + ": is a folder, not a YAML file");
}

TEST_F(ConfigFile, IncludedMappingsMergeUnderTheirIncluder) {
  write("base.yaml", "seed: 1\nicp:\n  iterations: 10\n  kind: point\n  list: [1, 2, 3]\n");
  const fs::path top =
      write("top.yaml", "include: base.yaml\nicp:\n  iterations: 20\n  list: [4]\nrate: 5\n");
  const ConfigNode config = ConfigNode::load(top);
  EXPECT_THAT(config.keys(), ElementsAre("seed", "icp", "rate"));
  const ConfigNode icp = config.section("icp");
  EXPECT_EQ(icp.get("iterations", 0), 20);
  EXPECT_EQ(icp.text("kind"), "point");
  EXPECT_THAT(icp.get("list", std::vector<double>{}), ElementsAre(4));
  EXPECT_EQ(config.where("seed"), path("base.yaml") + ":1");
  EXPECT_EQ(config.where("rate"), path("top.yaml") + ":5");
  EXPECT_EQ(icp.where("kind"), path("base.yaml") + ":4");
  EXPECT_EQ(icp.where("iterations"), path("top.yaml") + ":3");
  EXPECT_THAT(error_of([&] { config.finish(); }), StartsWith(path("base.yaml") + ":1: unknown key 'seed'"));
}

/// Every key has a default, so an empty section is a good one: it sets nothing and takes nothing away.
TEST_F(ConfigFile, AnEmptySectionKeepsWhatIsIncluded) {
  write("base.yaml", "icp:\n  iterations: 10\nlist: [1]\nrate: 5\n");
  ConfigNode config = ConfigNode::load(write("top.yaml", "include: base.yaml\nicp:\nlist:\nrate:\n"));
  EXPECT_EQ(config.section("icp").get("iterations", 0), 10);
  config.set("icp", "");
  EXPECT_EQ(config.section("icp").get("iterations", 0), 10);
  config.set("icp", "{}");
  EXPECT_EQ(config.section("icp").get("iterations", 0), 0);
  const std::string top = path("top.yaml");
  EXPECT_THAT(error_of([&] { config.get("list", std::vector<double>{}); }), StartsWith(top + ":3: 'list'"));
  EXPECT_THAT(error_of([&] { config.get("rate", 0); }), StartsWith(top + ":4: 'rate' must be"));
}

TEST_F(ConfigFile, ListsOfIncludesAndIncludesOfIncludes) {
  write("parts/deep.yaml", "a: 1\nb: 1\nc: 1\nd: 1\n");
  write("parts/one.yaml", "include: deep.yaml\nb: 2\nc: 2\nd: 2\n");
  write("parts/two.yaml", "c: 3\nd: 3\n");
  const ConfigNode config =
      ConfigNode::load(write("top.yaml", "include: [parts/one.yaml, parts/two.yaml]\nd: 4\n"));
  EXPECT_EQ(config.get("a", 0), 1);
  EXPECT_EQ(config.get("b", 0), 2);
  EXPECT_EQ(config.get("c", 0), 3);
  EXPECT_EQ(config.get("d", 0), 4);
  EXPECT_NO_THROW(config.finish());
}

TEST_F(ConfigFile, SectionsKnowTheFolderOfTheirFile) {
  write("parts/sensor.yaml", "calibration: {file: k.yaml}\n");
  const ConfigNode config = ConfigNode::load(write("top.yaml", "include: parts/sensor.yaml\n"));
  EXPECT_EQ(config.folder(), folder_);
  EXPECT_EQ(config.section("calibration").folder(), folder_ / "parts");
}

/// One key of a section that is included may be said anew: the paths beside it stay where they were.
TEST_F(ConfigFile, KeysKnowTheFolderOfTheirFile) {
  write("parts/sensor.yaml", "calibration: {file: k.yaml, sigma: 1}\n");
  const ConfigNode config =
      ConfigNode::load(write("top.yaml", "include: parts/sensor.yaml\ncalibration: {sigma: 2}\n"));
  EXPECT_EQ(config.section("calibration").folder("file"), folder_ / "parts");
  EXPECT_EQ(config.section("calibration").folder("sigma"), folder_);
  EXPECT_EQ(config.section("calibration").folder("none"), folder_);
}

/// Whoever writes a path on a command line does not know which file said it before.
TEST_F(ConfigFile, PathsOfOverridesAreRelativeToTheCurrentFolder) {
  write("parts/sensor.yaml", "calibration: {file: k.yaml, sigma: 1}\n");
  ConfigNode config = ConfigNode::load(write("top.yaml", "include: parts/sensor.yaml\n"));
  config.set("calibration.file", "mine.yaml");
  EXPECT_EQ(config.section("calibration").folder("file"), "");
  EXPECT_EQ(config.section("calibration").folder("sigma"), folder_ / "parts");
  config.set("live.driver.calibration", "mine.yaml");  // sections that no file has
  EXPECT_EQ(config.section("live").section("driver").folder("calibration"), "");
  config.set("scene", "{of: {walls: a/b.yaml}}");
  EXPECT_EQ(config.section("scene").section("of").folder("walls"), "");
}

TEST_F(ConfigFile, CirclesAndBadIncludesAreErrors) {
  write("a.yaml", "x: 1\ninclude: b.yaml\n");
  write("b.yaml", "include: ./sub/../a.yaml\n");
  fs::create_directories(folder_ / "sub");
  EXPECT_THAT(error_of([&] { ConfigNode::load(folder_ / "a.yaml"); }), HasSubstr("circle"));
  EXPECT_THAT(error_of([&] { ConfigNode::load(folder_ / "a.yaml"); }), StartsWith(path("b.yaml") + ":1: "));
  const fs::path self = write("self.yaml", "include: self.yaml\n");
  EXPECT_THAT(error_of([&] { ConfigNode::load(self); }), HasSubstr("circle"));

  const fs::path missing = write("missing.yaml", "a: 1\ninclude: gone.yaml\n");
  EXPECT_EQ(error_of([&] { ConfigNode::load(missing); }),
            path("missing.yaml") + ":2: includes " + path("gone.yaml") + ": no such file");
  const fs::path endless = write("endless.yaml", "include: /dev/zero\n");
  EXPECT_THAT(error_of([&] { ConfigNode::load(endless); }), HasSubstr("/dev/zero: is no ordinary file"));
  const fs::path longest = write("long.yaml", "include: " + std::string(300, 'x') + "\n");
  EXPECT_THAT(error_of([&] { ConfigNode::load(longest); }),
              ::testing::AllOf(StartsWith(path("long.yaml") + ":1: includes "), HasSubstr("too long")));
  const fs::path wrong = write("wrong.yaml", "include: {a: 1}\n");
  EXPECT_THAT(error_of([&] { ConfigNode::load(wrong); }), HasSubstr("must be a file name or a list"));

  // Includes that double at each level end with an error, not after 2^30 files.
  for (int i = 0; i < 30; ++i) {
    const std::string next = "n" + std::to_string(i + 1) + ".yaml";
    write("n" + std::to_string(i) + ".yaml",
          std::string("include: [").append(next).append(", ").append(next).append("]\n"));
  }
  write("n30.yaml", "a: 1\n");
  EXPECT_THAT(error_of([&] { ConfigNode::load(folder_ / "n0.yaml"); }), HasSubstr("includes"));
}

TEST(ConfigDamage, MutatedFilesGiveErrorsAndNeverCrash) {
  const std::string valid =
      "# demo\nseed: 7\nbase: &b {x: 1, y: [1, 2.5, -3e2]}\nother: *b\nfastslam:\n  particles: 200\n"
      "  text: \"quoted \\n text\"\n  block: |\n    two\n    lines\n  planar: true\nprocesses:\n"
      "  - name: surf\n    rate: 30\n  - name: 'icp'\n";
  const std::string alphabet = " \t\n:-[]{},&*#?|>!%@`'\"~<=\\a1.\xff\xc3\x80";
  int errors = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    std::mt19937_64 engine(seed);
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(engine() % n); };
    std::string text = valid;
    for (std::size_t edits = 1 + below(6); edits > 0 && !text.empty(); --edits) {
      const std::size_t at = below(text.size());
      const char letter = alphabet[below(alphabet.size())];
      switch (below(4)) {
        case 0:
          text[at] = letter;
          break;
        case 1:
          text.insert(at, 1 + below(3), letter);
          break;
        case 2:
          text.erase(at, 1 + below(8));
          break;
        default:
          text.insert(below(text.size()), text.substr(at, below(40)));
      }
    }
    try {
      const ConfigNode config = ConfigNode::parse(text);
      config.get("seed", 1);
      config.section("fastslam").get("particles", 1);
      config.section("base").get("y", std::vector<double>{});
      for (const ConfigNode& process : config.sections("processes")) process.get("name", "");
      config.finish();
    } catch (const ConfigError& error) {
      ++errors;
      ASSERT_THAT(error.what(), StartsWith("<text>")) << "seed " << seed;
    } catch (const std::exception& error) {
      FAIL() << "seed " << seed << ": " << error.what();
    }
  }
  EXPECT_GT(errors, 1000);
}

}  // namespace
}  // namespace lcmslam

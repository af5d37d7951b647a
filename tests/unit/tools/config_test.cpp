#include <gmock/gmock.h>

#include <fstream>
#include <set>
#include <sstream>

#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/config/check_file.hpp"
#include "tools/config/explain.hpp"
#include "tools/config/setting_sections.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::filesystem::path source = source_folder();

template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

/// YAML with one value under a dotted key.
std::string yaml(std::string key, std::string value) {
  for (std::size_t dot = key.rfind('.'); dot != std::string::npos; dot = key.rfind('.')) {
    value = std::string("{").append(key, dot + 1).append(": ").append(value).append("}");
    key = key.substr(0, dot);
  }
  return "\n" + key + ": " + value + "\n";
}

/// A section with what must be given, so that a process could read it, and one line more.
ConfigNode section_with(const SettingSection& section, const std::string& text) {
  ConfigNode config = ConfigNode::parse(text, "a.yaml");
  if (section.name == "camera" && text.find("scene") == std::string::npos)
    config.set("simulation.scene", "kitchen.yaml");
  return config;
}

/// Every setting of every section.
template <class Action>
void for_all(const Action& action) {
  for (const SettingSection& section : setting_sections())
    for (const SettingEntry& entry : section.entries) action(section, entry);
}

TEST(Settings, HaveAMeaningAndAKeyOfTheirOwn) {
  std::set<std::string> keys;
  for_all([&](const SettingSection& section, const SettingEntry& entry) {
    EXPECT_TRUE(keys.insert(section.key(entry)).second) << section.key(entry) << " stands twice";
    EXPECT_FALSE(entry.meaning.empty()) << section.key(entry);
    EXPECT_EQ(entry.meaning.find('\n'), std::string::npos) << section.key(entry);
  });
  EXPECT_GT(keys.size(), 300U);
}

TEST(Settings, DefaultsLieInTheirRanges) {
  for_all([](const SettingSection& section, const SettingEntry& entry) {
    if (entry.kind != "number" && entry.kind != "whole number") return;
    EXPECT_TRUE(entry.range.holds(std::stod(entry.value))) << section.key(entry) << " is " << entry.value;
    EXPECT_LT(entry.range.low, entry.range.high) << section.key(entry);
  });
}

// A section of the camera that is not chosen is not read.
bool is_read(const SettingSection& section, const SettingEntry& entry) {
  return section.name != "camera" || entry.path.find('.') == std::string::npos ||
         entry.path.rfind("simulation.", 0) == 0;
}

TEST(Settings, EachDefaultIsReadBack) {
  for_all([](const SettingSection& section, const SettingEntry& entry) {
    const std::string value = entry.required ? "some.yaml" : entry.value;
    const ConfigNode config = section_with(section, yaml(entry.path, value));
    EXPECT_EQ(error_of([&] {
                section.read(config);
                config.finish();
              }),
              "no error")
        << section.key(entry) << ": " << value;
  });
}

TEST(Settings, ValuesOutsideARangeAreRefusedWithFileAndLine) {
  int refused = 0;
  for_all([&](const SettingSection& section, const SettingEntry& entry) {
    if (!is_read(section, entry) || (entry.kind != "number" && entry.kind != "whole number")) return;
    for (const double value : {entry.range.low - 1, entry.range.high + 1}) {
      if (entry.range.holds(value) || std::abs(value) > 2e9) continue;  // too large for the difference
      const ConfigNode config = section_with(section, yaml(entry.path, number_text(value)));
      EXPECT_THAT(error_of([&] { section.read(config); }),
                  AllOf(StartsWith("a.yaml:2: '"), HasSubstr("must be"), HasSubstr(number_text(value))))
          << section.key(entry);
      ++refused;
    }
  });
  EXPECT_GT(refused, 400);
}

TEST(Settings, OtherKindsAreRefusedWithFileAndLine) {
  for_all([](const SettingSection& section, const SettingEntry& entry) {
    if (!is_read(section, entry)) return;
    const ConfigNode config = section_with(section, yaml(entry.path, "{of: another kind}"));
    EXPECT_THAT(error_of([&] { section.read(config); }), StartsWith("a.yaml:2: '")) << section.key(entry);
  });
}

TEST(Settings, APresetGivesOtherDefaults) {
  int found = 0;
  for_all([&](const SettingSection& section, const SettingEntry& entry) {
    if (section.key(entry) != "fastslam.resampling") return;
    ++found;
    EXPECT_EQ(section.defaults(entry), "systematic (thesis: multinomial)");
  });
  EXPECT_EQ(found, 1);
}

TEST(ConfigPage, IsNotStale) {
  std::ostringstream text;
  text << std::ifstream(source / "docs/CONFIGURATION.md").rdbuf();
  EXPECT_TRUE(text.str() == configuration_page())
      << "docs/CONFIGURATION.md is stale: ./lcmslam config --markdown > docs/CONFIGURATION.md";
}

TEST(ExplainKey, SaysEverything) {
  EXPECT_EQ(explain_key("icp.map.voxel_size"),
            "icp.map.voxel_size\n"
            "  of the map that frames are registered to\n"
            "  unit     m\n"
            "  must be  a number from 0.001 to 10\n"
            "  default  0.04\n"
            "  in YAML  icp: {map: {voxel_size: 0.04}}\n"
            "  or       --set icp.map.voxel_size=0.04\n");
  EXPECT_THAT(explain_key("fastslam.proposal"),
              AllOf(HasSubstr("one of 'motion', 'measurement'"), HasSubstr("measurement (thesis: motion)")));
}

TEST(ExplainKey, FindsKeysByTheirEnd) {
  EXPECT_THAT(explain_key("voxel_size"),
              AllOf(HasSubstr("icp.voxel_size\n"), HasSubstr("icp.map.voxel_size\n")));
  EXPECT_THAT(explain_key("icp.depth_clock"), HasSubstr("icp.depth_clock.prior"));
}

TEST(ExplainKey, NamesTheNearest) {
  EXPECT_THAT(error_of([] { explain_key("icp.voxel_sice"); }), HasSubstr("did you mean 'icp.voxel_size'"));
  EXPECT_THAT(error_of([] { explain_key("icp.voxel"); }), HasSubstr("did you mean 'icp.voxel_size'"));
  EXPECT_THAT(error_of([] { explain_key("voxel_sice"); }), HasSubstr("'icp.map.voxel_size'"));
  EXPECT_THAT(error_of([] { list_keys("fastslm"); }), HasSubstr("there are launch, camera, surf"));
}

TEST(ListKeys, ShowsASectionOrAll) {
  EXPECT_THAT(list_keys("surf"), AllOf(HasSubstr("surf.octaves "), Not(HasSubstr("icp."))));
  EXPECT_THAT(list_keys("icp.coarse"), AllOf(HasSubstr("icp.coarse.metric"), Not(HasSubstr("icp.fine"))));
  EXPECT_THAT(list_keys(""), AllOf(HasSubstr("launch.processes"), HasSubstr("map-server.resolution")));
}

TEST(CheckFile, WhatIsShippedIsRight) {
  for (const auto& [folder, kind] : {std::pair{"config/scenes", "a scene"},
                                     {"config/datasets", "a data set's description"},
                                     {"config/heads", "a sensor head"},
                                     {"config/calibration", "a calibration"}})
    for (const auto& file : std::filesystem::directory_iterator(source / folder))
      EXPECT_EQ(check_file(file.path()), kind) << file.path();
  int graphs = 0;
  for (const auto& file : std::filesystem::directory_iterator(source / "config")) {
    if (file.path().extension() != ".yaml") continue;
    std::vector<std::string> overrides;
    if (file.path().filename() == "dataset.yaml") overrides = {"camera.dataset.folder=x"};  // left to --data
    EXPECT_EQ(check_file(file.path(), overrides),
              file.path().filename() == "modern.yaml" ? "a preset" : "a graph")
        << file.path();
    ++graphs;
  }
  EXPECT_GE(graphs, 9);
  for (const auto& file : std::filesystem::directory_iterator(source / "config/cameras"))
    EXPECT_EQ(check_file(file.path()), "a graph") << file.path();
}

TEST(CheckFile, NamesFilesThatAreNotThere) {
  const testing::ScratchFolder scratch;
  std::filesystem::create_directory(scratch.path() / "parts");
  scratch.write("parts/head.yaml",
                "camera: {source: openni2, live: {calibration: k.yaml, jpeg_quality: 90}}\n");
  const auto graph = scratch.write("a.yaml",
                                   "include: parts/head.yaml\nlaunch: {processes: [camera]}\n"
                                   "camera: {live: {jpeg_quality: 80}}\n");
  const std::string wanted = (scratch.path() / "parts/k.yaml").string();
  EXPECT_THAT(missing_files(graph),
              ElementsAre(AllOf(HasSubstr("head.yaml:1"), HasSubstr("'calibration'"), HasSubstr(wanted))));
  scratch.write("parts/k.yaml", "");
  EXPECT_THAT(missing_files(graph), ElementsAre());
  EXPECT_THAT(missing_files(graph, {"launch.processes=[surf]", "camera.live.calibration=gone.yaml"}),
              ElementsAre());
  EXPECT_THAT(missing_files(source / "config/demo.yaml"), ElementsAre());
  EXPECT_THAT(missing_files(source / "config/cameras/kinect.yaml"), ElementsAre());
}

TEST(CheckFile, NamesWhatIsWrong) {
  const testing::ScratchFolder scratch;
  const auto error = [&](const std::string& text, const std::vector<std::string>& overrides = {}) {
    return error_of([&] { check_file(scratch.write("a.yaml", text), overrides); });
  };
  EXPECT_THAT(error("icp:\n  voxel_sice: 1\n"),
              EndsWith("a.yaml:2: unknown key 'voxel_sice' in 'icp' (did you "
                       "mean 'voxel_size'?)"));
  EXPECT_THAT(error("surf: {octaves: 9}\n"),
              EndsWith("a.yaml:1: 'octaves' must be a whole number from 1 to 6, "
                       "got '9'"));
  EXPECT_THAT(error("launch: {processes: [slam]}\n"), HasSubstr("got 'slam'"));
  EXPECT_THAT(error("surf: {}\n", {"surf.octaves=9"}), StartsWith("--set surf.octaves=9: 'octaves' must be"));
  EXPECT_THAT(error("rooms: []\n"), HasSubstr("'name' is missing"));
  EXPECT_THAT(error("format: mrclam\nsensor: {range_sigma: -1}\n"),
              HasSubstr("a.yaml:2: 'range_sigma' must be"));
  EXPECT_THAT(error("format: tum\ndepth_scal: 1\n"), HasSubstr("'depth_scale'"));
  EXPECT_THAT(error("kind: sonar\n"), HasSubstr("a.yaml:1: 'kind'"));
  EXPECT_THAT(error("faults: {stamp_jiter: 1}\n"), HasSubstr("'stamp_jitter'"));
  EXPECT_THAT(error("colour: {width: 640}\n"), HasSubstr("'height' is missing"));
  EXPECT_THAT(error_of([&] { check_file(scratch.path() / "none.yaml"); }), HasSubstr("none.yaml"));
}

}  // namespace
}  // namespace lcmslam

#include <gtest/gtest.h>

#include <unistd.h>
#include <fstream>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/configuration/config_json.hpp>

namespace lcmslam {
namespace {

class ConfigJson : public ::testing::Test {
 protected:
  ConfigJson() { std::filesystem::create_directories(folder_); }
  ~ConfigJson() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("lcmslam-config-json-" + std::to_string(getpid()));
};

TEST_F(ConfigJson, KeepsKindsAndOrder) {
  EXPECT_EQ(
      config_json(write("a.yaml", "b: {x: 0.1, y: [1, two, '3'], z: true}\na: no\n\"q\\\"\": \"a\\tb\"\n")),
      R"({"b": {"x": 0.10000000000000001, "y": [1, "two", "3"], "z": true}, "a": false, "q\"": "a\u0009b"})");
}

TEST_F(ConfigJson, HoldsWhatIsIncluded) {
  write("base.yaml", "surf: {octaves: 3, threshold: 7}\n");
  EXPECT_EQ(config_json(write("own.yaml", "include: base.yaml\nsurf: {octaves: 5}\n")),
            config_json(write("same.yaml", "surf: {octaves: 5, threshold: 7}\n")));
}

TEST_F(ConfigJson, WhatIsNoConfigurationIsAnError) {
  EXPECT_THROW(config_json(folder_ / "none.yaml"), ConfigError);
}

}  // namespace
}  // namespace lcmslam

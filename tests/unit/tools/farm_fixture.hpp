#pragma once
// Farms of a scratch folder, whose programs are a shell's, and results as batch tells them.

#include <gtest/gtest.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/unit/tools/scratch.hpp"
#include "tools/farm/farm.hpp"
#include "tools/farm/farm_results.hpp"

namespace lcmslam::testing {

/// As batch writes it.
inline nlohmann::json farm_summary(double icp, double fastslam, const std::string& key = "k") {
  using nlohmann::json;
  json s = {{"key", key}, {"events", json::array()}, {"frames", 40}, {"timing", {{"wall_seconds", 2.5}}}};
  s["paths"]["icp"] = {{"ate", {{"translation_rmse_m", icp}}}, {"tracked_fraction", 0.98}, {"lost", 3}};
  s["paths"]["fastslam"] = {{"ate", {{"translation_rmse_m", fastslam}}}};
  s["paths"]["odometry"] = {{"ate", {{"translation_rmse_m", 0.2}}}};
  return s;
}

inline FarmResult farm_result(const std::string& name, double icp, double fastslam) {
  FarmResult r;
  r.name = name;
  r.has_summary = true;
  r.icp = icp;
  r.fastslam = fastslam;
  return r;
}

class Farm : public ::testing::Test {
 protected:
  std::filesystem::path log(const std::string& name, const std::string& text = "log") {
    const std::filesystem::path file = scratch_.path() / "logs" / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
    return file;
  }
  /// Jobs whose program is a shell that notes that it ran, and writes a summary or does what it is told.
  FarmOptions farm(const std::vector<std::filesystem::path>& logs) {
    FarmOptions options;
    options.folder = scratch_.path() / "farm";
    options.jobs = farm_jobs(logs);
    options.at_a_time = 2;
    options.key = [](const FarmJob& job) { return "key of " + job.name; };
    options.command = [this](const FarmJob& job, const std::filesystem::path& folder,
                             const std::string& key) {
      const std::string ran = "echo " + job.name + " >> '" + (scratch_.path() / "ran").string() + "'; ";
      const auto own = commands_.find(job.name);
      const std::string then = own != commands_.end()
                                   ? own->second
                                   : "echo '" + farm_summary(0.01, 0.02, key).dump() + "' > '" +
                                         (folder / "summary.json").string() + "'";
      return std::vector<std::string>{"/bin/sh", "-c", ran + then};
    };
    return options;
  }
  std::string ran() { return scratch_.read("ran"); }

  ScratchFolder scratch_;
  std::map<std::string, std::string> commands_;
  std::ostringstream out_;
};

}  // namespace lcmslam::testing

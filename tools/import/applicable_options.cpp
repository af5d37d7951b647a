#include "tools/import/applicable_options.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <stdexcept>
#include <vector>

namespace lcmslam {
namespace {

struct Use {
  std::vector<RecordingKind> kinds;
  std::string words;
};

/// Of options that are not for everything.
std::map<std::string, Use> uses(const CLI::App& app) {
  using Kind = RecordingKind;
  std::map<std::string, Use> all = {
      {"--calibration", {{Kind::ros, Kind::images}, "recordings with images"}},
      {"--description", {{Kind::mrclam, Kind::victoria_park, Kind::images}, "data sets"}},
      {"--robot", {{Kind::mrclam}, "UTIAS MRCLAM"}},
      {"--repeat", {{Kind::images}, "data sets of images"}}};
  for (const CLI::Option* option : app.get_options())
    if (option->get_group() == ros_group) all[option->get_name()] = {{Kind::ros}, ros_group};
  return all;
}

std::string name_of(RecordingKind kind) {
  switch (kind) {
    case RecordingKind::ros:
      return "a recording of ROS";
    case RecordingKind::mrclam:
      return "a data set of UTIAS MRCLAM";
    case RecordingKind::victoria_park:
      return "Victoria Park's";
    case RecordingKind::images:
      break;
  }
  return "a data set of images";
}

}  // namespace

void check_applicable(const CLI::App& app, RecordingKind kind, const std::string& path) {
  for (const auto& [option, use] : uses(app))
    if (app.get_option(option)->count() > 0 &&
        std::find(use.kinds.begin(), use.kinds.end(), kind) == use.kinds.end())
      throw std::invalid_argument(
          fmt::format("{} is for {}; {} is {}", option, use.words, path, name_of(kind)));
}

}  // namespace lcmslam

#include <fmt/format.h>
#include <iostream>

#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/log/log_commands.hpp"
#include "tools/log/mcap_export.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

void print(const McapExport& done, const std::string& output) {
  std::int64_t messages = 0;
  for (const auto& [topic, count] : done.topics) {
    std::cout << fmt::format("  {:<36} {:>7}\n", topic, count);
    messages += count;
  }
  const auto print_channels = [](const char* what, const std::map<std::string, std::int64_t>& channels) {
    std::string list;
    for (const auto& [channel, count] : channels)
      list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", channel, count);
    if (!list.empty()) std::cout << "  left out, " << what << ": " << list << "\n";
  };
  print_channels("ROS has no such messages", done.without_counterpart);
  print_channels("do not decode", done.undecoded);
  for (const LogDamage& damage : done.damages)
    std::cout << fmt::format("  left out bytes {} to {}: {}\n", damage.begin, damage.end, damage.reason);
  std::cout << fmt::format("{}: {} messages on {} topics, {:.1f} MB\n", output, messages, done.topics.size(),
                           static_cast<double>(done.bytes) / 1e6);
}

}  // namespace

int log_export_command(int argc, char** argv) {
  std::vector<std::string> logs;
  std::string compression = "zstd";
  LogOutput output;
  CLI::App app{
      "Writes logs for other people's viewers: MCAP with ROS 2's messages (images, calibration, poses, tf, "
      "keyframes' clouds), for Foxglove, Lichtblick and ros2 bag.",
      "lcmslam log export"};
  app.add_option("--mcap", output.file, "the file that is written")->required();
  app.add_option("log", logs, "an .lcmlog file; several of one drive (the recording, batch's) become one")
      ->required();
  app.add_option("--compression", compression, "of its chunks")
      ->check(CLI::IsMember({"zstd", "lz4", "none"}));
  app.add_flag("--force", output.overwrite, "overwrite the file if it exists");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  install_stop_signals(0);
  print(export_mcap(logs, output, compression), output.file);
  return 0;
}

}  // namespace lcmslam

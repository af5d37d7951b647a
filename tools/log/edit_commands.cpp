#include <fmt/format.h>
#include <iostream>

#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/log/log_commands.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/log/selection_options.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

void print(const LogEdit& edit, const std::string& output) {
  for (const LogDamage& damage : edit.damages) {
    const std::string lost = damage.lost > 0 ? fmt::format(" ({} events lost)", damage.lost) : "";
    std::cout << fmt::format("  left out bytes {} to {}: {}{}\n", damage.begin, damage.end, damage.reason,
                             lost);
  }
  if (edit.incomplete > 0)
    std::cout << fmt::format("  left out {} messages of which pieces are missing\n", edit.incomplete);
  std::cout << fmt::format("{}: {} of {} events", output, edit.written, edit.read);
  if (edit.joined > 0) std::cout << fmt::format(", {} messages joined from pieces", edit.joined);
  std::cout << "\n";
}

void add_files(CLI::App& app, std::string& input, LogOutput& output) {
  app.add_option("input", input, "an .lcmlog file")->required();
  app.add_option("output", output.file, "file to write")->required();
  app.add_flag("--force", output.overwrite, "overwrite the output if it exists");
}

}  // namespace

int log_repair_command(int argc, char** argv) {
  std::string input;
  LogOutput output;
  CLI::App app{"Writes a new log with every whole event of a damaged one, and says what is lost.",
               "lcmslam log repair"};
  add_files(app, input, output);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  install_stop_signals(0);
  print(repair_log(input, output), output.file);
  return 0;
}

int log_cut_command(int argc, char** argv) {
  std::string input;
  LogOutput output;
  SelectionOptions options;
  CLI::App app{"Writes a new log with a span of time or some channels of another.", "lcmslam log cut"};
  add_files(app, input, output);
  options.add_to(app);
  std::string robot;
  app.add_option("--robot", robot,
                 "of a log of several robots only this one's channels, without its name: an ordinary log");
  app.add_option("--without", options.without, "not these channels")->delimiter(',');
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  install_stop_signals(0);
  print(cut_log(input, output, options.selection(), robot), output.file);
  return 0;
}

int log_calibrate_command(int argc, char** argv) {
  std::string input, file;
  LogOutput output;
  CLI::App app{"Writes a new log with a calibration from a file, at 1 Hz, in the place of its own.",
               "lcmslam log calibrate"};
  add_files(app, input, output);
  app.add_option("calibration", file, "calibration (YAML): ours, ROS's camera_info or OpenCV's")
      ->required()
      ->check(CLI::ExistingFile);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  install_stop_signals(0);
  const RgbdCalibration calibration = load_calibration(file);
  std::cout << file << ": " << describe(calibration) << "\n";
  print(calibrate_log(input, output, calibration), output.file);
  return 0;
}

}  // namespace lcmslam

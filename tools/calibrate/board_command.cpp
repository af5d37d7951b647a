#include <fmt/format.h>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

#include <lcmslam/files/atomic_file.hpp>
#include "tools/calibrate/board_options.hpp"
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/output_file.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

constexpr double dots_per_mm = 300 / 25.4;

std::string png(const Board& board) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", board.picture(cvRound(1000 * board.settings().square * dots_per_mm)), bytes);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

int calibrate_board_command(int argc, char** argv) {
  std::string output;
  bool force = false;
  BoardOptions options;
  CLI::App app{
      "Prints a board to calibrate cameras with: an .svg of its true size, or a .png of 300 dots an inch.",
      "lcmslam calibrate board"};
  app.add_option("output", output, "FILE.svg or FILE.png")->required();
  app.add_flag("--force", force, "overwrite the file if it exists");
  options.add_to(app);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  const std::string extension = std::filesystem::path(output).extension();
  if (extension != ".svg" && extension != ".png")
    throw std::runtime_error(output + ": a board is written as .svg or .png");
  check_output_file(output, force);
  const Board board = options.board();
  write_atomically(std::filesystem::path(output), extension == ".svg" ? board.svg() : png(board));
  std::cout << fmt::format(
      "{}: {} of {} x {} squares, {:.0f} x {:.0f} mm. Print it without scaling, glue it to something flat,\n"
      "measure a square with a ruler and give its side to the other commands with --square.\n",
      output, board.settings().kind, board.settings().columns, board.settings().rows, 1000 * board.width(),
      1000 * board.height());
  return 0;
}

}  // namespace lcmslam

#pragma once
#include <CLI/CLI.hpp>

#include <lcmslam/calibration/board.hpp>

namespace lcmslam {

/// Which board it is, as options of a command.
struct BoardOptions {
  BoardSettings settings;
  double square_mm = 1000 * BoardSettings().square;

  void add_to(CLI::App& app) {
    app.add_option("--board", settings.kind, "its kind (" + settings.kind + ")")
        ->check(CLI::IsMember({"charuco", "checkerboard"}));
    app.add_option("--columns", settings.columns,
                   "squares across (" + std::to_string(settings.columns) + ")");
    app.add_option("--rows", settings.rows, "squares down (" + std::to_string(settings.rows) + ")");
    app.add_option("--square", square_mm, "side of a square in mm, measured on the print (25)");
  }
  /// Throws std::invalid_argument that says what a board must be.
  Board board() {
    settings.square = 1e-3 * square_mm;
    return Board(settings);
  }
};

}  // namespace lcmslam

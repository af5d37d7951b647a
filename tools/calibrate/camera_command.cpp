#include <fmt/format.h>
#include <iostream>

#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/calibrate/board_options.hpp"
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/calibrate/calibration_output.hpp"
#include "tools/calibrate/camera_report.hpp"
#include "tools/calibrate/live_views.hpp"
#include "tools/calibrate/shots.hpp"
#include "tools/calibrate/view_choice.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

/// The views, as they come.
class ColourViews {
 public:
  ColourViews(const Board& board, const ShotInput& input, const CameraCalibrationSettings& settings)
      : board_(board), choice_(input.is_sequence()), live_(input.live), settings_(settings) {}

  bool take(const Shot& shot) {
    if (shot.colour.empty()) return true;
    ++images;
    camera.check(shot.name, shot.colour.size());
    auto view = find_board(shot.colour, board_);
    if (!view) return true;
    ++with_board;
    view->name = shot.name;
    if (!choice_.takes(*view, shot.colour.cols)) return true;
    views.push_back(std::move(*view));
    return !live_ || !tell_whether_enough(views, board_, camera.size(), settings_);
  }

  std::vector<BoardView> views;
  OneCamera camera;
  int images = 0, with_board = 0;

 private:
  const Board& board_;
  ViewChoice choice_;
  bool live_;
  CameraCalibrationSettings settings_;
};

/// A camera alone is the colour camera of a head whose depth images, if any, are registered to it.
RgbdCalibration with_colour(const std::optional<RgbdCalibration>& base, const CameraModel& camera,
                            const std::string& name) {
  RgbdCalibration calibration;
  if (base) {
    calibration = *base;
  } else {
    calibration.sensor = name;
    calibration.depth_registered = true;
  }
  calibration.colour = camera;
  if (calibration.depth_registered) calibration.depth = camera;
  return calibration;
}

}  // namespace

int calibrate_camera_command(int argc, char** argv) {
  ShotInput input;
  BoardOptions board_options;
  CalibrationOutput output;
  CameraCalibrationSettings settings;
  std::string pictures;
  CLI::App app{"Intrinsics and distortion of a camera from views of a board, and how good they are.",
               "lcmslam calibrate camera"};
  input.add_to(app);
  board_options.add_to(app);
  output.add_to(app, "calibration (YAML) to write");
  app.add_option("--coefficients", settings.coefficients,
                 "of the distortion; default: as many of 0, 4 and 5 as the views bear")
      ->check(CLI::IsMember({0, 4, 5, 8}));
  app.add_option("--pictures", pictures, "a folder for coverage.png and residuals.png");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  output.check();
  install_stop_signals(0);
  const Board board = board_options.board();
  ColourViews seen(board, input, settings);
  const auto of_input = read_shots(input, [&](const Shot& shot) { return seen.take(shot); });
  std::cout << fmt::format("{} images, {} with the board, {} views taken\n", seen.images, seen.with_board,
                           seen.views.size());
  if (seen.views.size() < 3)
    throw std::runtime_error(
        "too few views of the board: is it whole, flat and lit, and are --board, --columns and --rows its "
        "own?");
  const CameraCalibration calibration = calibrate_camera(seen.views, board, seen.camera.size(), settings);
  const ViewCoverage coverage = coverage_of(calibration, board);
  std::cout << camera_report(calibration, coverage);
  write_pictures(calibration, board, pictures);
  advise(wanted_views(calibration, coverage));
  if (const int refused = refuse(missing_views(calibration, coverage), output.accept)) return refused;
  output.write(
      with_colour(output.base(of_input), calibration.camera, std::filesystem::path(output.file).stem()),
      fmt::format("Colour camera by lcmslam calibrate camera: {} views, {:.3f} pixels RMS.",
                  calibration.views.size(), calibration.rms),
      camera_covariance(calibration, "colour"));
  return 0;
}

}  // namespace lcmslam

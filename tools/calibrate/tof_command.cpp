#include <fmt/format.h>
#include <iostream>

#include <lcmslam/calibration/range_error.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/calibrate/board_options.hpp"
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/calibrate/calibration_output.hpp"
#include "tools/calibrate/camera_report.hpp"
#include "tools/calibrate/live_views.hpp"
#include "tools/calibrate/range_choice.hpp"
#include "tools/calibrate/range_report.hpp"
#include "tools/calibrate/shots.hpp"
#include "tools/calibrate/view_choice.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

struct TofViews {
  std::vector<BoardView> views;
  std::vector<cv::Mat> depths;
  OneCamera camera;
  int images = 0;
};

/// What `calibrate camera` finds of a colour camera is all that is known of its head until now.
bool is_of_another_camera(const RgbdCalibration& base, const cv::Size& amplitude) {
  return base.colour.width != amplitude.width || base.colour.height != amplitude.height;
}

/// A ToF camera alone: its amplitude image is the colour image, too. Beside a colour camera of another size
/// it is a camera of its own, whose place `calibrate pair` finds. Throws std::runtime_error where it may be
/// none.
RgbdCalibration with_depth(const std::optional<RgbdCalibration>& base, const CameraModel& camera,
                           const DepthError& error, const std::string& name) {
  RgbdCalibration calibration;
  if (base) {
    calibration = *base;
    if (calibration.depth_registered) {
      calibration.depth_registered = false;
      calibration.T_colour_depth.setIdentity();
    }
  } else {
    calibration.sensor = name;
    calibration.depth_registered = true;
    calibration.colour = camera;
  }
  calibration.depth = camera;
  calibration.depth_error = error;
  return calibration;
}

RangeErrorFit fit_ranges(const TofViews& seen, const CameraCalibration& camera, const Board& board,
                         const RangeErrorFitSettings& settings) {
  std::vector<RangeSample> samples;
  for (std::size_t i = 0; i < seen.views.size(); ++i) {
    const auto pose = board_pose(seen.views[i], board, camera.camera);
    if (!pose || seen.depths[i].empty()) continue;
    const auto ranges = board_ranges(seen.depths[i], camera.camera, board, *pose,
                                     board_distance_sigma(camera.camera, board, pose->translation().z()));
    samples.insert(samples.end(), ranges.begin(), ranges.end());
  }
  return fit_range_error(samples, settings);
}

}  // namespace

int calibrate_tof_command(int argc, char** argv) {
  ShotInput input;
  BoardOptions board_options;
  board_options.settings.kind = "checkerboard";
  CalibrationOutput output;
  RangeErrorFitSettings range_settings;
  std::string pictures;
  CLI::App app{
      "A time-of-flight camera: intrinsics from its amplitude images, and what its ranges err by (offset, "
      "wiggle).",
      "lcmslam calibrate tof"};
  input.add_to(app);
  board_options.add_to(app);
  output.add_to(app, "calibration (YAML) to write");
  app.add_flag("--scale", range_settings.keep_scale, "corrects an apparent scale of the ranges, too");
  app.add_option("--pictures", pictures, "a folder for coverage.png and residuals.png");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  output.check();
  install_stop_signals(0);
  const Board board = board_options.board();
  ViewChoice choice(input.is_sequence());
  TofViews seen;
  const auto of_input = read_shots(input, [&](const Shot& shot) {
    if (shot.amplitude.empty()) return true;
    ++seen.images;
    seen.camera.check(shot.name, shot.amplitude.size());
    auto view = find_board(shot.amplitude, board);
    if (!view || !choice.takes(*view, shot.amplitude.cols)) return true;
    view->name = shot.name;
    seen.views.push_back(std::move(*view));
    seen.depths.push_back(shot.depth);
    return !input.live || !tell_whether_enough(seen.views, board, seen.camera.size(), {}, whole_period);
  });
  std::cout << fmt::format("{} amplitude images, {} views taken\n", seen.images, seen.views.size());
  const auto base = output.base(of_input);
  if (base && base->depth_registered && !is_of_another_camera(*base, seen.camera.size()))
    throw std::runtime_error(
        "the calibration says depth_registered, and its images have the amplitude's size: depth images that "
        "a "
        "driver registers to colour have the colour camera's geometry, and calibrate camera is what they "
        "need. "
        "A depth camera with a geometry of its own has depth_registered: false, depth and colour_depth "
        "there");
  if (seen.images == 0)
    throw std::runtime_error(
        "no amplitude image: this command needs a log whose CAMERA has them, or the folders amplitude/ and "
        "depth/");
  if (seen.views.size() < 3)
    throw std::runtime_error(
        "too few views of the board in amplitude images: its squares must be large, some 8 pixels "
        "at least (--square, --columns, --rows), and its paper not glossy");
  const CameraCalibration camera = calibrate_camera(seen.views, board, seen.camera.size());
  const ViewCoverage coverage = coverage_of(camera, board);
  std::cout << camera_report(camera, coverage);
  write_pictures(camera, board, pictures);
  range_settings.scale_sigma = std::max(5e-4, camera.sigma(0) / camera.camera.fx);
  const RangeErrorFit fit = fit_ranges(seen, camera, board, range_settings);
  std::cout << range_report(fit);
  advise(wanted_views(camera, coverage));
  if (const int refused = refuse(missing_views(camera, coverage), output.accept)) return refused;
  const bool unplaced = base && base->depth_registered;
  if (unplaced)
    std::cout << "  note: where it sits on the colour camera is not known yet: calibrate pair finds it\n";
  output.write(
      with_depth(base, camera.camera, fit.error, std::filesystem::path(output.file).stem()),
      fmt::format(
          "Depth camera by lcmslam calibrate tof: {} views, {:.3f} pixels RMS; ranges {:.1f} mm RMS.{}",
          camera.views.size(), camera.rms, 1e3 * fit.rms_after,
          unplaced ? " colour_depth is not known yet." : ""),
      camera_covariance(camera, "depth"));
  return 0;
}

}  // namespace lcmslam

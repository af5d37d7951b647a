#include <fmt/format.h>
#include <iostream>

#include <lcmslam/calibration/camera_pair.hpp>
#include <lcmslam/calibration/covariance_text.hpp>
#include <lcmslam/calibration/range_error.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/calibrate/board_options.hpp"
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/calibrate/calibration_output.hpp"
#include "tools/calibrate/range_choice.hpp"
#include "tools/calibrate/range_report.hpp"
#include "tools/calibrate/shots.hpp"
#include "tools/calibrate/units.hpp"
#include "tools/calibrate/view_choice.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

std::string pair_report(const PairCalibration& pair) {
  const Eigen::Vector3d t = mm_per_m * pair.T_colour_depth.translation();
  const Vector6d sigma = pair.covariance.diagonal().cwiseSqrt();
  return fmt::format(
      "  depth in colour  {:.1f}, {:.1f}, {:.1f} mm (+- {:.1f}, {:.1f}, {:.1f}), turned by {:.2f} degrees "
      "(+- {:.2f})\n"
      "  depth camera     fx {:.2f} +- {:.2f}, fy {:.2f} +- {:.2f}, cx {:.2f}, cy {:.2f} pixels\n"
      "  reprojection     {:.3f} pixels RMS in colour, {:.3f} in depth's amplitude; {} views\n",
      t.x(), t.y(), t.z(), mm_per_m * sigma[0], mm_per_m * sigma[1], mm_per_m * sigma[2],
      degrees_per_rad * rotation_angle(pair.T_colour_depth), degrees_per_rad * sigma.tail<3>().maxCoeff(),
      pair.depth.fx, std::sqrt(pair.depth_covariance(0, 0)), pair.depth.fy,
      std::sqrt(pair.depth_covariance(1, 1)), pair.depth.cx, pair.depth.cy, pair.colour_rms, pair.depth_rms,
      pair.views);
}

/// Ranges against the board where the colour camera sees it: of the depth camera's few pixels its own
/// distance would be less sure.
std::vector<RangeSample> ranges_of(const PairCalibration& pair, const std::vector<cv::Mat>& depths,
                                   const Board& board, const CameraModel& colour) {
  std::vector<RangeSample> samples;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!pair.T_depth_board[i] || depths[i].empty()) continue;
    const auto ranges =
        board_ranges(depths[i], pair.depth, board, *pair.T_depth_board[i],
                     board_distance_sigma(colour, board, pair.T_depth_board[i]->translation().z()));
    samples.insert(samples.end(), ranges.begin(), ranges.end());
  }
  return samples;
}

/// Takes over what ranges err by, where enough of them tell it.
void take_ranges(const PairCalibration& pair, const std::vector<RangeSample>& ranges,
                 RgbdCalibration& calibration) {
  constexpr std::size_t enough = 30;
  if (ranges.size() < enough) {
    advise({fmt::format(
        "what ranges err by (depth_error) stays as it was: the depth images show the board in {} "
        "ranges within {} m of where it is, and {} are needed",
        ranges.size(), gross_range_error, enough)});
    return;
  }
  RangeErrorFitSettings settings;
  settings.scale_sigma = std::max(5e-4, std::sqrt(pair.depth_covariance(0, 0)) / pair.depth.fx);
  const RangeErrorFit fit = fit_range_error(ranges, settings);
  std::cout << range_report(fit);
  const RangeChoice chosen = choose_range_error(calibration.depth_error, fit);
  calibration.depth_error = chosen.error;
  advise(chosen.kept);
}

std::vector<std::string> doubts(const PairCalibration& pair) {
  constexpr double enough = 0.003, enough_angle = 0.003;  // m, rad
  std::vector<std::string> missing;
  const Vector6d sigma = pair.covariance.diagonal().cwiseSqrt();
  if (pair.views < 6)
    missing.push_back(
        fmt::format("only {} views with the board in both images: at least 6, better 15", pair.views));
  if (sigma.head<3>().maxCoeff() > enough || sigma.tail<3>().maxCoeff() > enough_angle)
    missing.emplace_back(
        "the views do not tell enough: hold the board tilted, near and far, and all over the image");
  return missing;
}

}  // namespace

int calibrate_pair_command(int argc, char** argv) {
  ShotInput input;
  BoardOptions board_options;
  board_options.settings.kind = "checkerboard";
  CalibrationOutput output;
  CLI::App app{"How a colour and a depth camera sit on each other, from a board that both see at one moment.",
               "lcmslam calibrate pair"};
  input.add_to(app);
  board_options.add_to(app);
  output.add_to(app, "calibration (YAML) to write");
  PairSettings settings;
  bool hold = false;
  app.add_flag("--hold", hold, "the depth camera's intrinsics stay as they are");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  settings.refine_depth_camera = !hold;
  output.check();
  install_stop_signals(0);
  const Board board = board_options.board();
  ViewChoice choice(input.is_sequence());
  std::vector<PairView> views;
  std::vector<cv::Mat> depths;
  OneCamera colour_camera, depth_camera;
  int images = 0, of_both = 0;
  const auto of_input = read_shots(input, [&](const Shot& shot) {
    ++images;
    if (shot.colour.empty() || shot.amplitude.empty()) return true;
    ++of_both;
    colour_camera.check(shot.name, shot.colour.size());
    depth_camera.check(shot.name, shot.amplitude.size());
    auto depth = find_board(shot.amplitude, board);
    if (!depth) return true;
    // A place counts as looked at once both have seen the board there.
    auto colour = find_board(shot.colour, board);
    if (!colour || !choice.takes(*depth, shot.amplitude.cols)) return true;
    colour->name = depth->name = shot.name;
    if (input.live) tell_views(views.size() + 1);
    views.push_back({std::move(*colour), std::move(*depth)});
    depths.push_back(shot.depth);
    return true;
  });
  std::cout << fmt::format("{} shots, {} with the board in both images\n", images, views.size());
  if (of_both == 0)
    throw std::runtime_error(
        "no shot has a colour and an amplitude image: this command needs a log whose CAMERA has both, or the "
        "folders "
        "colour/, amplitude/ and depth/ with files of the same names");
  auto calibration = output.base(of_input);
  if (!calibration)
    throw std::runtime_error(
        "the intrinsics of both cameras must be known: give their calibration with --into");
  if (calibration->depth_registered)
    throw std::runtime_error(
        "the calibration says depth_registered: it knows one camera alone, whose geometry both images have. "
        "A depth "
        "camera of its own comes beside the colour camera with calibrate tof --into COLOUR.yaml");
  const PairCalibration pair =
      calibrate_pair(views, board, calibration->colour, calibration->depth, settings);
  std::cout << pair_report(pair);
  take_ranges(pair, ranges_of(pair, depths, board, calibration->colour), *calibration);
  if (const int refused = refuse(doubts(pair), output.accept)) return refused;
  calibration->T_colour_depth = pair.T_colour_depth;
  calibration->depth = pair.depth;
  output.write(
      *calibration, fmt::format("colour_depth by lcmslam calibrate pair: {} views.", pair.views),
      covariance_text("colour_depth", {"x", "y", "z", "rx", "ry", "rz"}, pair.covariance,
                      "T_colour_depth exp(xi): translation (m), then rotation (rad), depth camera's frame."));
  return 0;
}

}  // namespace lcmslam

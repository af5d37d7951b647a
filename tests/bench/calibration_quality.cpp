// How well cameras, their place on each other and on a robot, and wheels are found: a row a seed, in which
// everything is drawn anew.
//   build/release/bin/calibration_quality [--seeds 10] [--views 20]
//
// Cameras: rendered boards (lens distortion, blur, noise) before a colour camera of 640x480 and a
// time-of-flight camera of 176x144 whose ranges have an offset and a wiggle; both camera commands need no
// start, the pair begins with a depth camera whose focal length is 3 % off. Drives: figures of eight of a
// differential base with the simulation's wheel errors (2 and 3 % scale, 1 % and 0.5 degree of drift, slips),
// the camera's motion with noise as visual odometry has it, the mount's start 2 cm and 1 degree off; the
// floor is rendered for the depth camera and found by the head as its calibration left it.

#include <CLI/CLI.hpp>
#include <cstdio>

#include <lcmslam/calibration/camera_calibration.hpp>
#include <lcmslam/calibration/floor_sight.hpp>
#include <lcmslam/calibration/range_error.hpp>
#include "tests/support/board_shots.hpp"
#include "tests/support/camera_drive.hpp"
#include "tests/support/floor_before_wall.hpp"

namespace lcmslam {
namespace {

constexpr double degree = M_PI / 180;

struct Row {
  double colour_focal = 0, tof_focal = 0, pair_focal = 0;  // %
  double uncorrected = 0, ranges_alone = 0, ranges = 0;    // mm, largest within what was seen
  double pair_mm = 0, pair_degrees = 0;
  double mount_mm = 0, height_mm = 0, mount_degrees = 0;
  double radius = 0, track = 0;            // %
  double told_tof_focal = 0;               // %, one sigma of the ToF camera alone
  double told_mm = 0, told_height_mm = 0;  // sigmas that the calibration says, of the larger of x and y; of z
};

struct Corrected {
  DepthError error;  // as it was found
  double left = 0;   // mm, the largest of what the correction leaves
};

Corrected correct_ranges(const testing::HeadShots& shots,
                         const std::vector<std::optional<Eigen::Isometry3d>>& poses,
                         const CameraModel& camera, const CameraModel& placed_by, const Board& board,
                         double focal_sigma, const DepthError& truth) {
  std::vector<RangeSample> samples;
  for (std::size_t i = 0; i < shots.depths.size(); ++i) {
    if (!poses[i]) continue;
    const auto ranges = board_ranges(shots.depths[i], camera, board, *poses[i],
                                     board_distance_sigma(placed_by, board, poses[i]->translation().z()));
    samples.insert(samples.end(), ranges.begin(), ranges.end());
  }
  RangeErrorFitSettings settings;
  settings.scale_sigma = std::max(5e-4, focal_sigma);
  const RangeErrorFit fit = fit_range_error(samples, settings);
  Corrected result{fit.error};
  for (double r = fit.nearest; r < fit.farthest; r += 0.02)
    result.left = std::max(result.left, 1e3 * std::abs(fit.error.at(r) - truth.at(r)));
  return result;
}

/// The head as the calibration of its cameras leaves it.
RgbdCalibration measure_cameras(std::uint64_t seed, int views, Row& row) {
  const testing::RgbdTruth truth = testing::drawn_head(seed);
  const RgbdCalibration& c = truth.calibration;
  const auto focal_error = [](const CameraModel& found, const CameraModel& real) {
    return 100 * std::max(std::abs(found.fx / real.fx - 1), std::abs(found.fy / real.fy - 1));
  };
  const Board board;
  const CameraCalibration colour = calibrate_camera(testing::colour_views(board, c.colour, views, seed),
                                                    board, {c.colour.width, c.colour.height});
  row.colour_focal = focal_error(colour.camera, c.colour);

  const Board large = testing::large_board();
  const auto shots = testing::head_shots(large, truth, views + views / 2, seed);
  std::vector<BoardView> amplitudes;
  for (const PairView& pair : shots.pairs) amplitudes.push_back(pair.depth);
  const CameraCalibration tof = calibrate_camera(amplitudes, large, {c.depth.width, c.depth.height});
  row.tof_focal = focal_error(tof.camera, c.depth);
  row.told_tof_focal = 100 * std::max(tof.sigma(0) / tof.camera.fx, tof.sigma(1) / tof.camera.fy);
  std::vector<std::optional<Eigen::Isometry3d>> poses;
  for (const BoardView& view : amplitudes) poses.push_back(board_pose(view, large, tof.camera));
  row.ranges_alone =
      correct_ranges(shots, poses, tof.camera, tof.camera, large, tof.sigma(0) / tof.camera.fx, c.depth_error)
          .left;
  for (double r = 0.8; r < 3; r += 0.02)
    row.uncorrected = std::max(row.uncorrected, 1e3 * std::abs(c.depth_error.at(r)));

  // As on a robot: the colour camera as it was found, the depth camera's start 3 % off.
  CameraModel start = c.depth;
  start.fx *= 1.03, start.fy *= 1.03;
  const PairCalibration pair = calibrate_pair(shots.pairs, large, colour.camera, start);
  row.pair_focal = focal_error(pair.depth, c.depth);
  row.pair_mm = 1e3 * distance_between(pair.T_colour_depth, c.T_colour_depth);
  const Corrected ranges =
      correct_ranges(shots, pair.T_depth_board, pair.depth, colour.camera, large, 0, c.depth_error);
  row.ranges = ranges.left;
  row.pair_degrees = angle_between(pair.T_colour_depth, c.T_colour_depth) / degree;
  RgbdCalibration found = c;
  found.colour = colour.camera, found.depth = pair.depth, found.T_colour_depth = pair.T_colour_depth;
  found.depth_error = ranges.error;
  return found;
}

/// Found by the head as it was calibrated.
std::optional<FloorSight> seen_floor(const testing::RgbdTruth& truth, const RgbdCalibration& found,
                                     const Eigen::Isometry3d& mount, const Eigen::Isometry3d& expected,
                                     Random& random) {
  FloorWatch watch(found, expected);
  const DepthCorrector correct(found.depth, found.depth_error);
  for (int image = 0; image < 60; ++image) {
    cv::Mat depth = testing::floor_before_wall(truth, mount, random);
    correct(depth);
    watch.add(depth);
  }
  return watch.sight();
}

void measure_drive(std::uint64_t seed, int laps, double scale, const testing::RgbdTruth& truth,
                   const RgbdCalibration& head, Row& row) {
  Random random(seed, 41);
  const Eigen::Isometry3d mount = testing::drawn_mount(random);
  Vector6d off;
  for (int i = 0; i < 6; ++i) off[i] = random.normal();
  off.head<3>() *= 0.02 / off.head<3>().norm();
  off.tail<3>() *= degree / off.tail<3>().norm();

  const DrivenPath path(testing::figure_of_eight(laps, scale));
  const Utime begin = 1'000'000;
  const auto steps = wheel_steps(simulate_encoders(path, "differential", begin, seed));
  const Eigen::Isometry3d start = mount * se3_exp(off);
  const auto floor = seen_floor(truth, head, mount, start, random);
  if (!floor) std::printf("no floor is seen\n");
  const DriveCalibration found =
      calibrate_drive(cut_drive(testing::seen_motion(path, mount, begin, seed), steps), floor, start);
  const Eigen::Vector3d apart = found.T_robot_camera.translation() - mount.translation();
  row.mount_mm = 1e3 * apart.head<2>().norm();
  row.height_mm = 1e3 * std::abs(apart.z());
  const Vector6d sigmas = found.robot_sigmas();
  row.told_mm = 1e3 * std::max(sigmas[0], sigmas[1]);
  row.told_height_mm = 1e3 * sigmas[2];
  row.mount_degrees = angle_between(found.T_robot_camera, mount) / degree;

  // The scales that the wheels really had on this drive.
  double way = 0, turn = 0, true_way = 0, true_turn = 0;  // turns by regression: noise has both signs
  for (const WheelStep& step : steps) {
    const Eigen::Vector3d motion = step.by_wheel.rowwise().sum();
    way += motion.x();
    const auto seconds = [&](Utime t) { return 1e-6 * static_cast<double>(t - begin); };
    const Vector6d real = se3_log(path.pose(seconds(step.from)).inverse() * path.pose(seconds(step.to)));
    true_way += real[0];
    turn += motion.z() * real[5], true_turn += real[5] * real[5];
  }
  const double radius = 0.5 * (found.radius_factors[0] + found.radius_factors[1]);
  row.radius = 100 * std::abs(radius * way / true_way - 1);
  row.track = 100 * std::abs(radius * turn / true_turn / found.layout_factor - 1);
}

void print(const char* name, const Row& r) {
  std::printf(
      "%-6s %7.3f %7.3f %7.3f %8.1f %7.1f %7.1f %8.2f %7.3f %8.2f %7.2f %7.3f %8.2f %7.2f %8.2f %7.2f "
      "%8.3f\n",
      name, r.colour_focal, r.tof_focal, r.pair_focal, r.uncorrected, r.ranges_alone, r.ranges, r.pair_mm,
      r.pair_degrees, r.mount_mm, r.height_mm, r.mount_degrees, r.radius, r.track, r.told_mm,
      r.told_height_mm, r.told_tof_focal);
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  using namespace lcmslam;
  int seeds = 10, first = 1, views = 20, laps = 4;
  CLI::App app{"How well calibration finds what is known."};
  app.add_option("--seeds", seeds, "how many");
  app.add_option("--first", first, "the first seed");
  app.add_option("--views", views,
                 "of the board before the colour camera; the ToF camera gets half as many more");
  app.add_option("--laps", laps, "of the figure of eight, 15 m each");
  double scale = 1;
  app.add_option("--scale", scale, "of the figure of eight, 5 m x 1.8 m");
  bool drives_alone = false;
  app.add_flag("--drives", drives_alone, "measures mount and wheels alone, with cameras as they truly are");
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "errors    focal length, %%          ranges, mm               depth on colour     camera on robot      "
      "    "
      "wheels, %%     told sigma, mm   %%\n"
      "seed    colour     tof  in pair   before     tof in pair       mm  degree       xy  height  degree   "
      "radius   "
      " turn       xy  height      tof\n");
  std::vector<double Row::*> fields = {
      &Row::colour_focal, &Row::tof_focal,   &Row::pair_focal,     &Row::ranges,
      &Row::ranges_alone, &Row::uncorrected, &Row::pair_mm,        &Row::pair_degrees,
      &Row::mount_mm,     &Row::height_mm,   &Row::mount_degrees,  &Row::radius,
      &Row::track,        &Row::told_mm,     &Row::told_height_mm, &Row::told_tof_focal};
  Row worst;
  for (int seed = first; seed < first + seeds; ++seed) {
    Row row;
    const auto number = static_cast<std::uint64_t>(seed);
    const testing::RgbdTruth truth = testing::drawn_head(number);
    measure_drive(number, laps, scale, truth,
                  drives_alone ? truth.calibration : measure_cameras(number, views, row), row);
    print(std::to_string(seed).c_str(), row);
    std::fflush(stdout);
    for (const auto field : fields) worst.*field = std::max(worst.*field, row.*field);
  }
  print("worst", worst);
  return 0;
}

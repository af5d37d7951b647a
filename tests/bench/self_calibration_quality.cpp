// How well a head is calibrated without a board: the simulation knows the truth, the calibration begins
// beside it (focal length, the depth camera's place and direction), and what is found is compared. At the
// end, whether what is said of the errors is true: each number's error over its sigma, and all of them by
// their covariance (NEES, 1 for each number in the mean).
//   self_calibration_quality --head rgbd --seeds 10

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <lcmslam/calibration/self/drive_advice.hpp>
#include <lcmslam/calibration/self/head_calibration.hpp>
#include <lcmslam/calibration/self/recorded_scene.hpp>
#include <lcmslam/calibration/self/self_report.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>
#include <lcmslam/simulation/head_settings.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "procs/camera/camera_log.hpp"
#include "procs/camera/camera_source.hpp"

namespace lcmslam {
namespace {

struct Off {
  double focal = 0.03, translation = 0.02, degrees = 1;
};

struct Errors {
  double focal, translation, degrees;  // relative, m
  double focal_sigma, translation_sigma, degrees_sigma;
};

Eigen::Vector3d direction(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

RgbdCalibration spoiled(RgbdCalibration c, const Off& off, std::uint64_t seed) {
  Random random(seed, 77);
  const double factor = 1 + (random.uniform() < 0.5 ? -1 : 1) * off.focal;
  c.colour.fx *= factor, c.colour.fy *= factor;
  c.T_colour_depth.translation() += off.translation * direction(random);
  c.T_colour_depth.linear() =
      so3_exp(off.degrees * M_PI / 180 * direction(random)) * c.T_colour_depth.linear();
  return c;
}

Errors errors_of(const HeadModel& found, const RgbdCalibration& truth, const BundleResult& result) {
  const Eigen::Isometry3d T = found.T_colour_depth();
  const CameraModel c = found.colour();
  const auto& s = result.sigmas;
  return {std::max(std::abs(c.fx / truth.colour.fx - 1), std::abs(c.fy / truth.colour.fy - 1)),
          (T.translation() - truth.T_colour_depth.translation()).norm(),
          angle_between(T, truth.T_colour_depth) * 180 / M_PI,
          s[head::fx] / c.fx,
          std::sqrt(s[head::tx] * s[head::tx] + s[head::ty] * s[head::ty] + s[head::tz] * s[head::tz]),
          std::sqrt(s[head::rx] * s[head::rx] + s[head::ry] * s[head::ry] + s[head::rz] * s[head::rz]) * 180 /
              M_PI};
}

/// What is to be found, in the numbers of a head that begins at `start`.
HeadNumbers true_numbers(const RgbdCalibration& start, const RgbdCalibration& truth, double colour_rows) {
  HeadNumbers n = HeadModel(truth).values;
  const Eigen::Isometry3d T = start.T_colour_depth.inverse() * truth.T_colour_depth;
  const Eigen::Vector3d turn = so3_log(T.linear());
  for (std::size_t i = 0; i < 3; ++i) {
    n[head::tx + i] = T.translation()(static_cast<Eigen::Index>(i));
    n[head::rx + i] = turn(static_cast<Eigen::Index>(i));
  }
  n[head::colour_rows] = colour_rows;
  return n;
}

/// Errors over what was said of them, over seeds.
class Honesty {
 public:
  void add(const HeadModel& found, const HeadNumbers& truth, const BundleResult& result) {
    std::vector<int> free;
    for (int p = 0; p < head::count; ++p)
      if (!result.held(static_cast<head::Parameter>(p))) free.push_back(p);
    const auto n = static_cast<Eigen::Index>(free.size());
    Eigen::VectorXd errors(n);
    Eigen::MatrixXd covariance(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int p = free[static_cast<std::size_t>(i)];
      const auto at = static_cast<std::size_t>(p);
      errors(i) = found.values[at] - truth[at];
      const double z = errors(i) / result.sigmas[at];
      sums_[at] += z, squares_[at] += z * z, largest_[at] = std::max(largest_[at], std::abs(z));
      for (Eigen::Index k = 0; k < n; ++k)
        covariance(i, k) = result.covariance(p, free[static_cast<std::size_t>(k)]);
    }
    nees_ += errors.dot(covariance.ldlt().solve(errors)) / static_cast<double>(n);
    ++seeds_;
  }

  void print() const {
    std::printf("| error / sigma | mean | RMS | largest |\n|---|---|---|---|\n");
    for (std::size_t i = 0; i < head::count; ++i)
      if (largest_[i] > 0)
        std::printf("| %s | %.2f | %.2f | %.2f |\n", name_of(static_cast<head::Parameter>(i)).name,
                    sums_[i] / seeds_, std::sqrt(squares_[i] / seeds_), largest_[i]);
    std::printf("NEES of a number: %.2f\n", nees_ / seeds_);
  }

 private:
  HeadNumbers sums_{}, squares_{}, largest_{};
  double nees_ = 0;
  int seeds_ = 0;
};

double rolling_shutter_of(const SimulationSettings& settings) {
  const auto file = head_file(settings);
  return file.empty() ? settings.faults.rolling_shutter : load_head(file).rolling_shutter;
}

/// `log`: a recording whose calibration is the truth; empty: it is rendered.
Errors measure(const SimulationSourceSettings& settings, const std::string& log, const Off& off,
               const BundleSettings& bundle, const CalibrationPriors& priors, bool verbose,
               Honesty& honesty) {
  const auto source = log.empty() ? make_simulation_source(settings) : open_log(log);
  const RgbdCalibration truth = source->calibration(), start = spoiled(truth, off, settings.simulation.seed);
  RecordedScene recording(start, {});
  WheelOdometry wheels;
  while (const auto event = source->next()) {
    if (const auto* frame = std::get_if<EncodedFrame>(&*event)) recording.add(decode(*frame));
    if (const auto* encoders = std::get_if<Encoders>(&*event))
      if (const auto sample = wheels.update(*encoders)) recording.add(*sample);
  }
  SceneObservations scene = recording.observations();
  HeadModel model(start);
  const BundleResult result = calibrate_head(model, scene, priors, bundle);
  if (verbose) {
    HeadModel right(truth);
    std::printf(
        "%d of %d frames, %zu keyframes, %zu landmarks, %d pixels within %.2f, %d depths within %.2f, %d "
        "rounds\n%s",
        recording.tracked(), recording.frames(), scene.keyframes.size(), scene.landmarks.size(),
        result.pixels, result.pixel_scale, result.depths, result.depth_scale, result.rounds,
        report_text(model, result, bundle).c_str());
    const Eigen::Isometry3d D = truth.T_colour_depth.inverse() * model.T_colour_depth();
    const Eigen::Vector3d t = 1e3 * D.translation(), r = so3_log(D.linear()) * 180 / M_PI;
    std::printf(
        "  truth: fx %.5g, cx %.5g, cy %.5g, k1 %.4g, k2 %.4g; errors of colour_depth: %.2f %.2f %.2f mm, "
        "%.3f %.3f %.3f degrees\n",
        truth.colour.fx, truth.colour.cx, truth.colour.cy, right.values[head::k1], right.values[head::k2],
        t.x(), t.y(), t.z(), r.x(), r.y(), r.z());
    const auto most = static_cast<std::size_t>(RecordedSceneSettings().keyframes);
    for (const std::string& advice : drive_advice(model, result, scene.keyframes.size(), most))
      std::printf("  note: %s\n", advice.c_str());
  }
  honesty.add(model, true_numbers(start, truth, log.empty() ? rolling_shutter_of(settings.simulation) : 0),
              result);
  return errors_of(model, truth, result);
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  using namespace lcmslam;
  CLI::App app{"How well a head is calibrated without a board, against the simulation's truth."};
  SimulationSourceSettings settings;
  settings.render = "cached";
  settings.simulation.scene = "config/scenes/kitchen.yaml";
  settings.simulation.head = "rgbd";
  settings.simulation.seconds = 24;
  settings.simulation.frame_rate = 5;
  Off off;
  int first = 1, seeds = 10;
  bool verbose = false;
  std::string log;
  BundleSettings bundle;
  CalibrationPriors priors;
  app.add_option("--rounds", bundle.rounds, "of least squares");
  app.add_option("--iterations", bundle.iterations, "of a round");
  app.add_option("--range-curve", priors.range_curve,
                 "what all ranges err by, over the depth noise of a pixel");
  app.add_option("--log", log, "a recording whose calibration is the truth, in the place of the simulation")
      ->check(CLI::ExistingFile);
  app.add_option("--scene", settings.simulation.scene, "scene (YAML)")->check(CLI::ExistingFile);
  app.add_option("--head", settings.simulation.head, "rgbd, tof or one of config/heads");
  app.add_option("--seconds", settings.simulation.seconds, "of the drive");
  app.add_option("--laps", settings.simulation.laps,
                 "in which the path is driven; --seconds 0: the whole of it");
  app.add_option("--rate", settings.simulation.frame_rate, "Hz of the images");
  app.add_option("--first", first, "seed");
  app.add_option("--seeds", seeds, "how many");
  app.add_option("--focal", off.focal, "that the focal length is off, relative");
  app.add_option("--translation", off.translation, "m that the depth camera is off");
  app.add_option("--degrees", off.degrees, "that it is turned");
  app.add_flag("--verbose", verbose, "each parameter of each seed");
  CLI11_PARSE(app, argc, argv);
  settings.simulation.scene = std::filesystem::absolute(settings.simulation.scene).lexically_normal();
  std::printf("head %s, %.0f s at %.0f Hz; start: %.1f %%, %.1f mm, %.2f degrees off\n",
              settings.simulation.head.c_str(), settings.simulation.seconds, settings.simulation.frame_rate,
              100 * off.focal, 1e3 * off.translation, off.degrees);
  std::printf(
      "| seed | focal length, %% (sigma) | translation, mm (sigma) | rotation, degrees (sigma) "
      "|\n|---|---|---|---|\n");
  Errors worst{};
  Honesty honesty;
  for (int i = first; i < first + seeds; ++i) {
    settings.simulation.seed = static_cast<std::uint64_t>(i);
    const Errors e = measure(settings, log, off, bundle, priors, verbose, honesty);
    std::printf("| %d | %.3f (%.3f) | %.2f (%.2f) | %.3f (%.3f) |\n", i, 100 * e.focal, 100 * e.focal_sigma,
                1e3 * e.translation, 1e3 * e.translation_sigma, e.degrees, e.degrees_sigma);
    std::fflush(stdout);
    worst.focal = std::max(worst.focal, e.focal);
    worst.translation = std::max(worst.translation, e.translation);
    worst.degrees = std::max(worst.degrees, e.degrees);
  }
  std::printf("| worst | %.3f | %.2f | %.3f |\n", 100 * worst.focal, 1e3 * worst.translation, worst.degrees);
  honesty.print();
  return 0;
}

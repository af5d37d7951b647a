#include <lcmslam/simulation/simulation.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/settings/check.hpp>
#include <lcmslam/simulation/colour_camera.hpp>
#include <lcmslam/simulation/driven_path.hpp>
#include <lcmslam/simulation/kept_views.hpp>
#include <lcmslam/simulation/sensor_head.hpp>
#include <lcmslam/simulation/wheel_base.hpp>

namespace lcmslam {
namespace {

constexpr Utime start_time = 1'000'000;
constexpr std::int64_t most_kept = 8'000'000'000;  // bytes of views of one lap
enum Sensor : std::uint64_t { colour_sensor = 1, depth_sensor, depth_moment, colour_stamp, depth_stamp };

// Bases that drive sideways turn up to 20 degrees away from their path, so that it matters.
HeadingSway sway_of(const std::string& base) {
  return {is_holonomic(base) ? 0.35 : 0.0, 6.0};
}

SensorHead head_of(const SimulationSettings& settings, const Scene& scene, const RayCaster& caster) {
  const std::filesystem::path file = head_file(settings);
  if (file.empty()) return make_head(settings.head, scene, caster, {}, settings.unit);
  return make_head(load_head(file), scene, caster, settings.unit);
}

/// Lap after lap.
DrivenPath path_of(const SimulationSettings& settings, const Scene& scene, Utime image_period) {
  const auto laps = [&](int count) {
    return PlanarPath(control_points(scene, count), PathLimits(), sway_of(settings.base));
  };
  const std::vector<CarryingWheel> wheels = carrying_wheels(settings.base);
  constexpr int planned = RepeatedLap::planned_laps;
  if (settings.laps <= planned || is_holonomic(settings.base))  // whose swaying knows no laps
    return {laps(settings.laps), scene.ground, wheels};
  const PlanarPath plan = laps(planned);
  const double lap_length = plan.length() - laps(planned - 1).length();
  return {plan, scene.ground, wheels, RepeatedLap(plan, lap_length, settings.laps - planned, image_period)};
}

ColourSensor colour_sensor_of(const SensorHead& head) {
  ColourSensor sensor;
  sensor.exposure = head.exposure;
  return sensor;
}

SimulationSettings checked(const SimulationSettings& settings) {
  check(settings, "simulation");
  return settings;
}

}  // namespace

std::filesystem::path head_file(const SimulationSettings& settings) {
  if (settings.head == "tof" || settings.head == "rgbd") return {};
  const std::filesystem::path given = settings.head;
  if (given.extension() == ".yaml") return given;
  const std::filesystem::path named =
      settings.scene.parent_path().parent_path() / "heads" / (settings.head + ".yaml");
  if (std::filesystem::exists(named)) return named;
  throw std::invalid_argument("head '" + settings.head + "' is not known: use tof, rgbd, a name of " +
                              named.parent_path().string() + " or a .yaml file");
}

struct Simulation::Parts {
  explicit Parts(const SimulationSettings& given)
      : settings(checked(given)),
        scene(load_scene(settings.scene)),
        caster(scene),
        head(head_of(settings, scene, caster)),
        faults(with_faults(settings.faults, head.faults)),
        colour(scene, caster, head.built.colour, colour_sensor_of(head)),
        frame_rate(settings.frame_rate > 0 ? settings.frame_rate : head.frame_rate),
        path(path_of(settings, scene, frame_period())),
        encoders(simulate_encoders(path, settings.base, start_time, settings.seed)),
        depth_offset(static_cast<Utime>(Random(settings.seed, 0xde).uniform(-12'000, 12'000))) {
    if (faults.rolling_shutter > 0) head.rolling_shutter = faults.rolling_shutter;
  }

  Utime frame_period() const { return static_cast<Utime>(1e6 / frame_rate); }

  Eigen::Isometry3d T_world_camera(Utime utime) const {
    return path.pose(static_cast<double>(utime - start_time) * 1e-6) * head.built.T_robot_camera;
  }

  /// Of a camera at T_colour_camera on the head.
  RowPoses row_poses(Utime utime, const Eigen::Isometry3d& T_colour_camera, double readout) const {
    const Eigen::Isometry3d before = T_world_camera(utime - 5000) * T_colour_camera,
                            after = T_world_camera(utime + 5000) * T_colour_camera;
    return {T_world_camera(utime) * T_colour_camera, se3_log(before.inverse() * after) / 0.01, readout};
  }

  /// Of the depth image that is taken with the colour image of this moment.
  Utime depth_moment_of(Utime moment) const {
    const double jitter = PixelNoise::uniform(PixelNoise(settings.seed, depth_moment, moment).bits(0));
    return moment + depth_offset + static_cast<Utime>(4000 * jitter - 2000);
  }

  RowPoses colour_poses(Utime moment) const {
    return row_poses(moment, Eigen::Isometry3d::Identity(), head.rolling_shutter);
  }

  /// A moment that comes again is rendered once.
  CameraViews see(Utime moment) const {
    const bool again = path.lap().comes_again(moment - start_time);
    CameraViews views;
    if (again && kept.find(moment, views)) return views;
    views.colour = colour.see(colour_poses(moment), settings.threads);
    views.depth = head.depth->see(
        row_poses(depth_moment_of(moment), head.built.T_colour_depth, head.depth_rolling_shutter),
        settings.threads);
    if (again) kept.keep(moment, views);
    return views;
  }

  /// Follows the light with a delay: the mean of the wanted gains' logarithms over the past, whose weights
  /// fall off with the time constant.
  float gain(Utime utime) const {
    constexpr double wanted = 110;  // mean grey value
    constexpr int samples = 6;
    const double constant = faults.exposure_adaptation;
    if (!(constant > 0)) return 1;
    double sum = 0, weights = 0;
    for (int i = 0; i < samples; ++i) {
      const double age = 0.5 * i, weight = std::exp(-age);
      const auto then = utime - static_cast<Utime>(1e6 * age * constant);
      const double brightness = std::max(1.0, colour.brightness(T_world_camera(then)));
      sum += weight * std::log(std::clamp(wanted / brightness, 0.125, 8.0));
      weights += weight;
    }
    return static_cast<float>(std::exp(sum / weights));
  }

  /// What a stamp says of a moment.
  Utime stamp(Utime moment, Utime shot, Sensor sensor, double error) const {
    const double jitter = faults.stamp_jitter;
    if (jitter > 0)
      error += jitter * (2 * PixelNoise::uniform(PixelNoise(settings.seed, sensor, shot).bits(0)) - 1);
    return moment + head.clock + static_cast<Utime>(std::llround(1e6 * error));
  }

  const SimulationSettings settings;
  const Scene scene;
  const RayCaster caster;
  SensorHead head;
  const CameraFaults faults;
  const ColourCamera colour;
  const double frame_rate;  // Hz
  const DrivenPath path;
  const std::vector<Encoders> encoders;
  const Utime depth_offset;  // us, of this run; up to 2 ms of jitter besides
  mutable KeptViews kept{most_kept};
};

Simulation::Simulation(const SimulationSettings& settings) : parts_(std::make_unique<Parts>(settings)) {}
Simulation::~Simulation() = default;

const RgbdCalibration& Simulation::calibration() const {
  return parts_->head.calibration;
}
const RgbdCalibration& Simulation::true_calibration() const {
  return parts_->head.built;
}
Utime Simulation::start() const {
  return start_time;
}
double Simulation::frame_rate() const {
  return parts_->frame_rate;
}
Utime Simulation::frame_period() const {
  return parts_->frame_period();
}
double Simulation::path_length() const {
  return parts_->path.length();
}

Utime Simulation::end() const {
  const double whole = parts_->path.duration(), wanted = parts_->settings.seconds;
  return start_time + static_cast<Utime>(1e6 * (wanted > 0 ? std::min(wanted, whole) : whole));
}

Eigen::Isometry3d Simulation::T_world_robot(Utime utime) const {
  return parts_->path.pose(static_cast<double>(utime - start_time) * 1e-6);
}

const Encoders& Simulation::encoders(Utime utime) const {
  const auto last = static_cast<Utime>(parts_->encoders.size()) - 1;
  const Utime index = std::clamp<Utime>((utime - start_time) / encoder_period, 0, last);
  return parts_->encoders[static_cast<std::size_t>(index)];
}

RgbdFrame Simulation::render(Utime utime) const {
  const SimulationSettings& settings = parts_->settings;
  const CameraFaults& faults = parts_->faults;
  const SensorHead& head = parts_->head;
  RgbdFrame frame;
  frame.utime = parts_->stamp(utime, utime, colour_stamp, faults.image_stamp_error);
  frame.seq = std::llround(static_cast<double>(utime - start_time) * 1e-6 * frame_rate());
  frame.sensor = head.calibration.sensor;

  // What is seen is that of the first moment that is like this one; the noise is this one's own.
  const Utime moment = start_time + parts_->path.lap().first(utime - start_time);
  const CameraViews seen = parts_->see(moment);
  frame.colour = parts_->colour.expose(seen.colour, parts_->colour_poses(moment).velocity,
                                       PixelNoise(settings.seed, colour_sensor, utime), settings.threads,
                                       parts_->gain(moment));
  frame.depth_utime = parts_->stamp(utime + parts_->depth_moment_of(moment) - moment, utime, depth_stamp,
                                    faults.image_stamp_error + faults.depth_stamp_error);
  head.depth->measure(seen.depth, PixelNoise(settings.seed, depth_sensor, utime), settings.threads, frame);
  return frame;
}

double Simulation::distance_to_surface(const Eigen::Vector3d& point_world) const {
  return parts_->caster.distance(point_world);
}

}  // namespace lcmslam

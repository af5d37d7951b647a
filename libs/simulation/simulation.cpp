#include <lcmslam/simulation/simulation.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/settings/check.hpp>
#include <lcmslam/simulation/colour_camera.hpp>
#include <lcmslam/simulation/driven_path.hpp>
#include <lcmslam/simulation/sensor_head.hpp>
#include <lcmslam/simulation/wheel_base.hpp>

namespace lcmslam {
namespace {

constexpr Utime start_time = 1'000'000;
enum Sensor : std::uint64_t { colour_sensor = 1, depth_sensor, depth_moment, colour_stamp, depth_stamp };

// Bases that drive sideways turn up to 20 degrees away from their path, so that it matters.
HeadingSway sway_of(const std::string& base) {
  return {is_holonomic(base) ? 0.35 : 0.0, 6.0};
}

SensorHead head_of(const SimulationSettings& settings, const Scene& scene, const RayCaster& caster) {
  const std::filesystem::path file = head_file(settings);
  if (file.empty()) return make_head(settings.head, scene, caster);
  return make_head(load_head(file), scene, caster);
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
        colour(scene, caster, head.calibration.colour, colour_sensor_of(head)),
        path(PlanarPath(control_points(scene, settings.laps), PathLimits(), sway_of(settings.base)),
             scene.ground, carrying_wheels(settings.base)),
        encoders(simulate_encoders(path, settings.base, start_time, settings.seed)),
        depth_offset(static_cast<Utime>(Random(settings.seed, 0xde).uniform(-12'000, 12'000))) {
    if (settings.frame_rate > 0) head.frame_rate = settings.frame_rate;
    if (settings.faults.rolling_shutter > 0) head.rolling_shutter = settings.faults.rolling_shutter;
  }

  Eigen::Isometry3d T_world_camera(Utime utime) const {
    return path.pose(static_cast<double>(utime - start_time) * 1e-6) * head.calibration.T_robot_camera;
  }

  /// Of a camera at T_colour_camera on the head.
  RowPoses row_poses(Utime utime, const Eigen::Isometry3d& T_colour_camera, double readout) const {
    const Eigen::Isometry3d before = T_world_camera(utime - 5000) * T_colour_camera,
                            after = T_world_camera(utime + 5000) * T_colour_camera;
    return {T_world_camera(utime) * T_colour_camera, se3_log(before.inverse() * after) / 0.01, readout};
  }

  /// Follows the light with a delay: the mean of the wanted gains' logarithms over the past, whose weights
  /// fall off with the time constant.
  float gain(Utime utime) const {
    constexpr double wanted = 110;  // mean grey value
    constexpr int samples = 6;
    const double constant = settings.faults.exposure_adaptation;
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
    const double jitter = settings.faults.stamp_jitter;
    if (jitter > 0)
      error += jitter * (2 * PixelNoise::uniform(PixelNoise(settings.seed, sensor, shot).bits(0)) - 1);
    return moment + static_cast<Utime>(std::llround(1e6 * error));
  }

  const SimulationSettings settings;
  const Scene scene;
  const RayCaster caster;
  SensorHead head;
  const ColourCamera colour;
  const DrivenPath path;
  const std::vector<Encoders> encoders;
  const Utime depth_offset;  // us, of this run; up to 2 ms of jitter besides
};

Simulation::Simulation(const SimulationSettings& settings) : parts_(std::make_unique<Parts>(settings)) {}
Simulation::~Simulation() = default;

const RgbdCalibration& Simulation::calibration() const {
  return parts_->head.calibration;
}
Utime Simulation::start() const {
  return start_time;
}
double Simulation::frame_rate() const {
  return parts_->head.frame_rate;
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
  const CameraFaults& faults = settings.faults;
  const SensorHead& head = parts_->head;
  RgbdFrame frame;
  frame.utime = parts_->stamp(utime, utime, colour_stamp, faults.image_stamp_error);
  frame.seq = std::llround(static_cast<double>(utime - start_time) * 1e-6 * frame_rate());
  frame.sensor = head.calibration.sensor;

  frame.colour = parts_->colour.render(
      parts_->row_poses(utime, Eigen::Isometry3d::Identity(), head.rolling_shutter),
      PixelNoise(settings.seed, colour_sensor, utime), settings.threads, parts_->gain(utime));

  const double jitter = PixelNoise::uniform(PixelNoise(settings.seed, depth_moment, utime).bits(0));
  const Utime depth_moment_utime = utime + parts_->depth_offset + static_cast<Utime>(4000 * jitter - 2000);
  frame.depth_utime = parts_->stamp(depth_moment_utime, utime, depth_stamp,
                                    faults.image_stamp_error + faults.depth_stamp_error);
  head.depth->render(
      parts_->row_poses(depth_moment_utime, head.calibration.T_colour_depth, head.depth_rolling_shutter),
      PixelNoise(settings.seed, depth_sensor, utime), settings.threads, frame);
  return frame;
}

double Simulation::distance_to_surface(const Eigen::Vector3d& point_world) const {
  return parts_->caster.distance(point_world);
}

}  // namespace lcmslam

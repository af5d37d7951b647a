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
enum Sensor : std::uint64_t { colour_sensor = 1, depth_sensor, stamp_jitter };

// Bases that drive sideways turn up to 20 degrees away from their path, so that it matters.
HeadingSway sway_of(const std::string& base) {
  return {is_holonomic(base) ? 0.35 : 0.0, 6.0};
}

SimulationSettings checked(const SimulationSettings& settings) {
  check(settings, "simulation");
  return settings;
}

}  // namespace

struct Simulation::Parts {
  explicit Parts(const SimulationSettings& given)
      : settings(checked(given)),
        scene(load_scene(settings.scene)),
        caster(scene),
        head(make_head(settings.head, scene, caster)),
        colour(scene, caster, head.calibration.colour),
        path(PlanarPath(control_points(scene, settings.laps), PathLimits(), sway_of(settings.base)),
             scene.ground, carrying_wheels(settings.base)),
        encoders(simulate_encoders(path, settings.base, start_time, settings.seed)),
        depth_offset(static_cast<Utime>(Random(settings.seed, 0xde).uniform(-12'000, 12'000))) {
    if (settings.frame_rate > 0) head.frame_rate = settings.frame_rate;
  }

  Eigen::Isometry3d T_world_camera(Utime utime) const {
    return path.pose(static_cast<double>(utime - start_time) * 1e-6) * head.calibration.T_robot_camera;
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
  RgbdFrame frame;
  frame.utime = utime;
  frame.seq = std::llround(static_cast<double>(utime - start_time) * 1e-6 * frame_rate());
  frame.sensor = settings.head;

  const Eigen::Isometry3d before = parts_->T_world_camera(utime - 5000),
                          after = parts_->T_world_camera(utime + 5000);
  const Vector6d velocity = se3_log(before.inverse() * after) / 0.01;
  frame.colour = parts_->colour.render(parts_->T_world_camera(utime), velocity,
                                       PixelNoise(settings.seed, colour_sensor, utime), settings.threads);

  const double jitter = PixelNoise::uniform(PixelNoise(settings.seed, stamp_jitter, utime).bits(0));
  frame.depth_utime = utime + parts_->depth_offset + static_cast<Utime>(4000 * jitter - 2000);
  const Eigen::Isometry3d T_world_depth =
      parts_->T_world_camera(frame.depth_utime) * parts_->head.calibration.T_colour_depth;
  parts_->head.depth->render(T_world_depth, PixelNoise(settings.seed, depth_sensor, utime), settings.threads,
                             frame);
  return frame;
}

double Simulation::distance_to_surface(const Eigen::Vector3d& point_world) const {
  return parts_->caster.distance(point_world);
}

}  // namespace lcmslam

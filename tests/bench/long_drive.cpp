// What the map server's derived maps cost on a long drive: laps through the simulated kitchen at 10 Hz, shown
// as the map server shows them (decoding, free space at every frame, the surface three times a second,
// keyframes where the mapper would make them). One lap is rendered and driven again and again.
//   build/release/bin/long_drive [--minutes 60] [--head rgbd]
// A row for each tenth of it: CPU of one core (share of real time), longest frame, memory of the layers,
// resident memory of the program without the rendered lap's growth.

#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iostream>

#include <CLI/CLI.hpp>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "procs/map-server/layer_feed.hpp"
#include "tests/bench/cpu_time.hpp"

namespace lcmslam {
namespace {

struct Shot {
  EncodedFrame frame;
  Eigen::Isometry3d T_world_robot;  // at the depth image's time
};

double resident_mb() {
  std::ifstream pages("/proc/self/statm");
  double whole = 0, resident = 0;
  pages >> whole >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

std::vector<Shot> render_lap(const Simulation& simulation) {
  std::vector<Shot> lap;
  for (Utime t = simulation.start() + 100'000; t < simulation.end(); t += 100'000) {
    Shot shot;
    shot.frame = encode(simulation.render(t));
    shot.T_world_robot =
        simulation.T_world_robot(simulation.calibration().depth_time(shot.frame.depth.utime));
    lap.push_back(std::move(shot));
  }
  return lap;
}

/// Where the mapper would make a keyframe: none of the others stands near.
bool is_new_place(const std::vector<Eigen::Isometry3d>& keyframes, const Eigen::Isometry3d& T) {
  for (const Eigen::Isometry3d& known : keyframes)
    if (distance_between(known, T) < 0.3 && angle_between(known, T) < 0.3) return false;
  return true;
}

void drive(double minutes, const std::string& head) {
  SimulationSettings simulated;
  simulated.scene = "config/scenes/kitchen.yaml";
  simulated.head = head;
  simulated.threads = 2;
  const Simulation simulation(simulated);
  const RgbdCalibration& calibration = simulation.calibration();
  std::vector<Shot> lap = render_lap(simulation);
  LayerSettings settings;
  settings.map.background = false;
  LayerFeed feed(settings);
  feed.calibrate(calibration);
  std::vector<Eigen::Isometry3d> keyframes;
  std::vector<double> times;
  const auto frames = static_cast<std::size_t>(600 * minutes);
  std::printf("%zu frames a lap of %.1f m, %.0f MB resident before\n", lap.size(), simulation.path_length(),
              resident_mb());
  const auto lap_time = static_cast<Utime>(100'000 * lap.size());
  for (std::size_t i = 0; i < frames; ++i) {
    const Shot& shot = lap[i % lap.size()];
    const Utime later = static_cast<Utime>(i / lap.size()) * lap_time;
    EncodedFrame frame = shot.frame;
    frame.utime += later;
    frame.depth.utime += later;
    const double begin = cpu_milliseconds();
    feed.camera(frame);
    const Utime depth_time = calibration.depth_time(frame.depth.utime);
    feed.pose(depth_time, shot.T_world_robot);
    const Eigen::Isometry3d T_world_camera =
        simulation.T_world_robot(shot.frame.utime) * calibration.T_robot_camera;
    if (is_new_place(keyframes, T_world_camera)) {
      keyframes.push_back(T_world_camera);
      feed.keyframe({static_cast<std::int32_t>(keyframes.size()), frame.utime, T_world_camera, {}, 0});
    }
    times.push_back(cpu_milliseconds() - begin);
    if ((i + 1) % (frames / 10) != 0) continue;
    double sum = 0;
    for (const double time : times) sum += time;
    std::printf(
        "%5.1f min: %.0f %% of a core (longest frame %.0f ms), %zu keyframes, layers %.0f MB, resident %.0f "
        "MB\n",
        static_cast<double>(i + 1) / 600, sum / static_cast<double>(times.size()), quantile(times, 1),
        keyframes.size(), 1e-6 * static_cast<double>(feed.map()->memory_bytes()), resident_mb());
    std::fflush(stdout);
    times.clear();
  }
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  double minutes = 60;
  std::string head = "rgbd";
  CLI::App app("What the map server's derived maps cost on a long drive");
  app.add_option("--minutes", minutes, "of the drive")->check(CLI::Range(0.2, 10'000.0));
  app.add_option("--head", head)->check(CLI::IsMember({"tof", "rgbd"}));
  CLI11_PARSE(app, argc, argv);
  try {
    lcmslam::drive(minutes, head);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

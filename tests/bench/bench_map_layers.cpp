// What derived maps cost, one thread, on the kitchen's VGA depth images; OctoMap beside them.
//   build/release/bin/bench_map_layers --benchmark_repetitions=10 --benchmark_report_aggregates_only=true

#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <cmath>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/live_map/live_space.hpp>
#include <lcmslam/map_layers/carved_keyframes.hpp>
#include <lcmslam/map_layers/navigation_grid.hpp>
#include <lcmslam/map_query/collision.hpp>
#include <lcmslam/map_query/frontiers.hpp>
#include <lcmslam/map_query/newest_frame.hpp>
#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/sensor_head.hpp>
#include "tests/bench/cpu_time.hpp"
#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

/// A drive through the kitchen, an image every 0.3 s.
struct Drive {
  CameraModel camera;
  std::vector<Eigen::Isometry3d> robot, T_map_camera;
  std::vector<cv::Mat> depths;

  Drive() {
    cv::setNumThreads(1);
    const Scene scene = load_scene(source_folder() / "config/scenes/kitchen.yaml");
    const RayCaster caster(scene);
    const SensorHead head = make_head("rgbd", scene, caster, {640, 480});
    camera = head.calibration.depth;
    const PlanarPath path(scene.path);
    for (double t = 0; t < std::min(path.duration(), 24.0); t += 0.3) {
      robot.push_back(path.pose(t));
      T_map_camera.push_back(robot.back() * head.calibration.T_robot_camera *
                             head.calibration.T_colour_depth);
      RgbdFrame frame;
      head.depth->render(T_map_camera.back(), PixelNoise(1, 2, static_cast<int>(10 * t)), 1, frame);
      depths.push_back(frame.depth);
    }
  }
  static const Drive& instance() {
    static const Drive drive;
    return drive;
  }
};

OccupancySettings cells_of(const benchmark::State& state) {
  OccupancySettings settings;
  settings.cell_size = 0.01 * static_cast<double>(state.range(0));
  return settings;
}

OccupancyGrid carved(const OccupancySettings& settings, DepthCarver& carver) {
  const Drive& drive = Drive::instance();
  OccupancyGrid grid(settings);
  for (std::size_t i = 0; i < drive.depths.size(); ++i)
    carver.carve(drive.depths[i], drive.camera, drive.T_map_camera[i], grid);
  return grid;
}

/// m^3 of the box around all that is known, as maps' sizes are told elsewhere, and of the known cells alone.
struct Volume {
  double box, known;
};
Volume volume_of(const OccupancyGrid& grid) {
  std::size_t known = 0;
  Eigen::AlignedBox3i box;
  BlockLogOdds cells;
  for (const Eigen::Vector3i& block : grid.blocks()) {
    grid.load(block, cells);
    for (int i = 0; i < block_cells; ++i) {
      if (cells[static_cast<std::size_t>(i)] == unknown_log_odds) continue;
      ++known;
      box.extend(cell_at(block, i));
    }
  }
  const double cell = std::pow(grid.settings().cell_size, 3);
  return {cell * (box.sizes().array() + 1).cast<double>().prod(), cell * static_cast<double>(known)};
}

/// An image, and what the map of the drive takes.
void occupancy(benchmark::State& state) {
  const Drive& drive = Drive::instance();
  OccupancyGrid grid(cells_of(state));
  DepthCarver carver;
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t k = i++ % drive.depths.size();
    carver.carve(drive.depths[k], drive.camera, drive.T_map_camera[k], grid);
    benchmark::DoNotOptimize(grid.take_changes());
  }
  while (i < drive.depths.size()) {
    carver.carve(drive.depths[i], drive.camera, drive.T_map_camera[i], grid);
    ++i;
  }
  const Volume volume = volume_of(grid);
  const double kilobytes = 1e-3 * static_cast<double>(grid.memory_bytes());
  state.counters["kB"] = kilobytes;
  state.counters["kB_per_m3_of_box"] = kilobytes / volume.box;
  state.counters["kB_per_m3_known"] = kilobytes / volume.known;
}
BENCHMARK(occupancy)->Arg(4)->Arg(5)->Arg(2)->Unit(benchmark::kMillisecond);

void octomap_occupancy(benchmark::State& state) {
  const Drive& drive = Drive::instance();
  octomap::OcTree tree(cells_of(state).cell_size);
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t k = i++ % drive.depths.size();
    octomap::Pointcloud cloud;
    cloud.reserve(drive.depths[k].total());
    for (int v = 0; v < drive.depths[k].rows; ++v)
      for (int u = 0; u < drive.depths[k].cols; ++u) {
        const double z = 0.001 * drive.depths[k].at<std::uint16_t>(v, u);
        if (z <= 0 || z > 5) continue;
        const Eigen::Vector3f p = (drive.T_map_camera[k] * (z * drive.camera.ray({u, v}))).cast<float>();
        cloud.push_back(p.x(), p.y(), p.z());
      }
    const Eigen::Vector3f t = drive.T_map_camera[k].translation().cast<float>();
    tree.insertPointCloud(cloud, octomap::point3d(t.x(), t.y(), t.z()), -1, false, true);
  }
  state.counters["MB"] = 1e-6 * static_cast<double>(tree.memoryUsage());
}
BENCHMARK(octomap_occupancy)->Arg(4)->Unit(benchmark::kMillisecond);

/// The distance field after each image, all along the drive.
void field_update(benchmark::State& state) {
  const Drive& drive = Drive::instance();
  for (auto _ : state) {
    OccupancyGrid grid(cells_of(state));
    DepthCarver carver;
    DistanceField field(grid.settings().cell_size, {2});
    double longest = 0, sum = 0;
    for (std::size_t i = 0; i < drive.depths.size(); ++i) {
      carver.carve(drive.depths[i], drive.camera, drive.T_map_camera[i], grid);
      const auto changes = grid.take_changes();
      const double begin = cpu_milliseconds();
      field.update(changes);
      const double taken = cpu_milliseconds() - begin;
      longest = std::max(longest, taken);
      sum += taken;
    }
    state.SetIterationTime(1e-3 * sum / static_cast<double>(drive.depths.size()));
    state.counters["longest_ms"] = longest;
    state.counters["kB_per_m3_of_box"] =
        1e-3 * static_cast<double>(field.memory_bytes()) / volume_of(grid).box;
  }
}
BENCHMARK(field_update)->Arg(4)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);

struct Fields {
  DepthCarver carver;
  OccupancyGrid grid = carved({}, carver);
  DistanceField map{0.04, {2}};
  NewestFrame newest{0.04};
  Fields() {
    map.update(grid.take_changes());
    newest.show(carver.hits());
  }
  static const Fields& instance() {
    static const Fields fields;
    return fields;
  }
};

void distance_query(benchmark::State& state) {
  const Fields& fields = Fields::instance();
  const Drive& drive = Drive::instance();
  Random random(1);
  std::vector<Eigen::Vector3d> points;
  points.reserve(4096);
  for (int i = 0; i < 4096; ++i)
    points.emplace_back(drive.robot[static_cast<std::size_t>(i) % drive.robot.size()].translation() +
                        Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 2)));
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(fields.map.sample(points[i++ % points.size()]));
}
BENCHMARK(distance_query)->Unit(benchmark::kMicrosecond);

/// A thousand poses of a robot of 0.5 x 0.5 x 1.4 m where it drove, against map and newest frame.
void path_of_1000_poses(benchmark::State& state) {
  const Fields& fields = Fields::instance();
  const Drive& drive = Drive::instance();
  const CollisionChecker checker({&fields.map, &fields.newest.field()});
  const Box robot{Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.8)), {0.25, 0.25, 0.65}};
  std::vector<Eigen::Isometry3d> path;
  for (int i = 0; i < 1000; ++i) {
    const double at = i * static_cast<double>(drive.robot.size() - 1) / 1000;
    const auto from = static_cast<std::size_t>(at);
    path.push_back(interpolate(drive.robot[from], drive.robot[from + 1], at - static_cast<double>(from)));
  }
  double collisions = 0;
  for (auto _ : state) {
    collisions = 0;
    for (const Eigen::Isometry3d& pose : path)
      collisions += checker.collides(Box{pose * robot.T_map_box, robot.half_size}) ? 1 : 0;
  }
  state.counters["collisions"] = collisions;
}
BENCHMARK(path_of_1000_poses)->Unit(benchmark::kMillisecond);

/// The first question waits for distances that have rested for so many of the drive's images.
void question_after_rest(benchmark::State& state) {
  const Drive& drive = Drive::instance();
  const auto rested = static_cast<std::size_t>(state.range(0));
  LiveMapSettings settings;
  settings.background = false;
  for (auto _ : state) {
    state.PauseTiming();
    LiveSpace space(settings);
    const auto ask = [&] {
      return space.ask([](const LiveSpace::View& view) { return view.distances.memory_bytes(); });
    };
    std::size_t i = 0;
    for (; i < drive.depths.size() - rested; ++i) {
      space.show(drive.depths[i], drive.camera, drive.T_map_camera[i]);
      ask();
    }
    for (; i < drive.depths.size(); ++i) space.show(drive.depths[i], drive.camera, drive.T_map_camera[i]);
    state.ResumeTiming();
    benchmark::DoNotOptimize(ask());
  }
}
BENCHMARK(question_after_rest)->Arg(1)->Arg(80)->Iterations(10)->Unit(benchmark::kMillisecond);  // each a
                                                                                                 // drive

void newest_frame(benchmark::State& state) {
  const Drive& drive = Drive::instance();
  OccupancyGrid grid({});
  DepthCarver carver;
  std::vector<std::vector<OccupancyChange>> hits;
  for (std::size_t i = 0; i < 10; ++i) {
    carver.carve(drive.depths[i], drive.camera, drive.T_map_camera[i], grid);
    hits.push_back(carver.hits());
  }
  NewestFrame newest(0.04);
  std::size_t i = 0;
  for (auto _ : state) newest.show(hits[i++ % hits.size()]);
}
BENCHMARK(newest_frame)->Unit(benchmark::kMillisecond);

void navigation(benchmark::State& state) {
  const Fields& fields = Fields::instance();
  for (auto _ : state)
    benchmark::DoNotOptimize(make_navigation_grid(fields.grid, {}, Drive::instance().robot.back()));
}
BENCHMARK(navigation)->Unit(benchmark::kMillisecond);

void frontier_list(benchmark::State& state) {
  const Fields& fields = Fields::instance();
  for (auto _ : state) benchmark::DoNotOptimize(find_frontiers(fields.grid));
}
BENCHMARK(frontier_list)->Unit(benchmark::kMillisecond);

/// What a frame between keyframes costs so that a correction of the graph keeps what it saw; each tenth of
/// the drive's images is a keyframe.
void frame_that_hangs_on_a_keyframe(benchmark::State& state) {
  const Drive& drive = Drive::instance();
  OccupancyGrid grid({});
  DepthCarver carver;
  std::vector<std::vector<OccupancyChange>> hits;
  for (std::size_t i = 0; i < drive.depths.size(); ++i) {
    carver.carve(drive.depths[i], drive.camera, drive.T_map_camera[i], grid);
    hits.push_back(carver.hits());
  }
  std::size_t cells = 0, keyframes_kept = 0;
  for (auto _ : state) {
    CarvedKeyframes keyframes({});
    for (std::size_t i = 0, last = 0; i < drive.depths.size(); ++i) {
      if (i % 10 == 0) {
        state.PauseTiming();
        keyframes.add(static_cast<int>(last = i), drive.depths[i], drive.camera, drive.T_map_camera[i]);
        state.ResumeTiming();
      }
      keyframes.follow(static_cast<int>(last), drive.T_map_camera[last], hits[i], grid);
    }
    cells = keyframes.cells_of_frames();
    keyframes_kept = keyframes.size();
  }
  state.counters["frames"] = static_cast<double>(hits.size());
  state.counters["cells_a_keyframe"] = static_cast<double>(cells) / static_cast<double>(keyframes_kept);
}
BENCHMARK(frame_that_hangs_on_a_keyframe)->Unit(benchmark::kMillisecond);

/// After a correction of the graph: all of the drive's images as keyframes.
void carve_anew(benchmark::State& state) {
  const Fields& fields = Fields::instance();
  const Drive& drive = Drive::instance();
  CarvedKeyframes keyframes({});
  for (std::size_t i = 0; i < drive.depths.size(); ++i)
    keyframes.add(static_cast<int>(i), drive.depths[i], drive.camera, drive.T_map_camera[i]);
  for (auto _ : state)
    benchmark::DoNotOptimize(keyframes.carve_anew({}, fields.grid, Eigen::Vector3f::Zero()));
  state.counters["keyframes"] = static_cast<double>(keyframes.size());
}
BENCHMARK(carve_anew)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam

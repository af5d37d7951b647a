// Which of a simulated room's walls, floors and level tops the plane map finds, and how well. True planes are
// those of the scene's triangles, upright or level, that a plane map could know: at least --area of one was
// seen without noise, within --range and at less than 75 degrees of incidence, in two frames at least (a
// plane seen once counts nowhere) and where it is 12 cm wide (a strip is no wall, and outlines are told to 3
// cm). Found: 80 % of that lies within 3 cm of the outlines of patches in that plane, which is within 1
// degree. Of those that are found: the share of tilts (two each) and of distances at the patch's centre that
// lie within three of the sigmas which the patch tells, and their RMS in sigmas (1: honest).
//   build/release/bin/planes_quality [--seeds 3] [--seed 1] [--scene kitchen] [--head rgbd]

#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>
#include <utility>

#include <CLI/CLI.hpp>

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/planes/plane_map.hpp>
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/simulation.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

constexpr double cell = 0.04;  // m, in which seen points count once a frame

struct Options {
  std::string scene = "kitchen", head = "rgbd";
  int seeds = 1, seed = 1;
  double area = 0.1, range = 4;
};

struct TruePlane {
  struct Cell {
    Eigen::Vector3d point;
    int looks = 0, last_frame = -1;
  };
  Eigen::Vector3d normal;
  double offset = 0;
  std::map<std::pair<int, int>, Cell> cells;  // of the plane's own axes

  void add(const Eigen::Vector3d& point, int frame) {
    const Eigen::Vector3d x = std::abs(normal.z()) > 0.5 ? Eigen::Vector3d::UnitX().eval()
                                                         : Eigen::Vector3d::UnitZ().cross(normal).eval();
    const auto at = [](double c) { return static_cast<int>(std::floor(c / cell)); };
    Cell& seen = cells[{at(x.dot(point)), at(normal.cross(x).dot(point))}];
    if (seen.last_frame != frame) ++seen.looks;
    seen.last_frame = frame;
    seen.point = point;
  }
  bool is_known(int x, int y) const {
    const auto found = cells.find({x, y});
    return found != cells.end() && found->second.looks > 1;
  }
  /// A point of each cell that was seen in two frames and belongs to a square of 3 x 3 of such cells.
  std::vector<Eigen::Vector3d> points() const {
    std::set<std::pair<int, int>> wide;
    for (const auto& [at, seen] : cells) {
      int around = 0;
      for (int i = 0; i < 9; ++i) around += is_known(at.first + i % 3 - 1, at.second + i / 3 - 1) ? 1 : 0;
      if (around < 9) continue;
      for (int i = 0; i < 9; ++i) wide.insert({at.first + i % 3 - 1, at.second + i / 3 - 1});
    }
    std::vector<Eigen::Vector3d> all;
    for (const auto& at : wide) all.push_back(cells.at(at).point);
    return all;
  }
};
using TruePlanes = std::map<std::tuple<int, int, int, int>, TruePlane>;  // normal in 1/50, offset in 5 mm

void add_seen(const RayCaster& caster, const Scene& scene, const RgbdCalibration& calibration, double far,
              const Eigen::Isometry3d& T_world_depth, int number, TruePlanes& planes) {
  const CameraModel& camera = calibration.depth;
  const int step = std::max(1, camera.width / 160);
  const Eigen::Isometry3f T = T_world_depth.cast<float>();
  for (int v = step / 2; v < camera.height; v += step)
    for (int u = step / 2; u < camera.width; u += step) {
      RayPacket packet;
      const Eigen::Vector3f direction = T.linear() * camera.ray({u, v}).cast<float>();
      for (int k = 0; k < RayPacket::size; ++k) {
        packet.x[k] = direction.x();
        packet.y[k] = direction.y();
        packet.z[k] = direction.z();
      }
      caster.cast(T.translation(), packet);
      const double range = static_cast<double>(packet.range[0]);
      if (packet.triangle[0] == RayPacket::none || range > far || range < calibration.depth_min) continue;
      const SceneTriangle& t = scene.triangles[packet.triangle[0]];
      Eigen::Vector3d normal =
          (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]).cast<double>().normalized();
      if (normal.dot(direction.cast<double>()) > 0) normal = -normal;
      if (normal.dot(direction.normalized().cast<double>()) > -0.259) continue;  // 75 degrees
      if (std::abs(normal.z()) > 0.02 && normal.z() < 0.9998) continue;
      const Eigen::Vector3d point = (T.translation() + packet.range[0] * direction).cast<double>();
      const double offset = -normal.dot(point);
      const auto part = [](double c) { return static_cast<int>(std::lround(50 * c)); };
      TruePlane& plane = planes[{part(normal.x()), part(normal.y()), part(normal.z()),
                                 static_cast<int>(std::lround(offset / 0.005))}];
      plane.normal = normal;
      plane.offset = offset;
      plane.add(point, number);
    }
}

/// Share of the points within the outlines of the patches that lie in their plane; the best such patch's
/// fit.
double covered(const TruePlane& plane, const std::vector<Eigen::Vector3d>& points,
               const std::vector<PlanePatch>& patches, PlaneFit& best) {
  std::size_t inside = 0, most = 0;
  std::vector<bool> taken(points.size(), false);
  for (const PlanePatch& patch : patches) {
    if (patch.fit.plane.normal.dot(plane.normal) < std::cos(0.05)) continue;
    const Eigen::Vector3d x = patch.fit.axis, y = patch.fit.plane.normal.cross(x);
    std::vector<cv::Point2f> outline;
    for (const Eigen::Vector3d& p : patch.outline)
      outline.emplace_back(static_cast<float>(x.dot(p)), static_cast<float>(y.dot(p)));
    std::size_t own = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d& p = points[i];
      if (std::abs(patch.fit.plane.distance(p)) > 0.02) continue;
      // Within 3 cm of the outline counts.
      if (cv::pointPolygonTest(outline, {static_cast<float>(x.dot(p)), static_cast<float>(y.dot(p))}, true) <
          -0.03)
        continue;
      ++own;
      if (!taken[i]) ++inside;
      taken[i] = true;
    }
    if (own <= most) continue;
    most = own;
    best = patch.fit;
  }
  return static_cast<double>(inside) / static_cast<double>(points.size());
}

/// What planes err by in sigmas that they tell.
struct Told {
  int inside = 0, all = 0;
  double squares = 0;
  void add(double error, double variance) {
    inside += error * error < 9 * variance ? 1 : 0;
    squares += error * error / variance;
    ++all;
  }
};

/// The true plane against a patch's, in the patch's own frame (PlaneFit::variance).
void compare(const TruePlane& truth, const PlaneFit& fit, Told& tilts, Told& distances) {
  tilts.add(truth.normal.dot(fit.plane.normal.cross(fit.axis)), fit.variance[0]);
  tilts.add(truth.normal.dot(fit.axis), fit.variance[1]);
  distances.add(truth.normal.dot(fit.centre) + truth.offset, fit.variance[2]);
}

std::string text(const Told& told) {
  char words[64];
  const int all = std::max(told.all, 1);
  std::snprintf(words, sizeof words, "%5.0f %% %7.1f", 100.0 * told.inside / all,
                std::sqrt(told.squares / all));
  return words;
}

void run(const Options& options, std::uint64_t seed) {
  SimulationSettings simulated;
  simulated.scene = source_folder().string() + "/config/scenes/" + options.scene + ".yaml";
  simulated.head = options.head;
  simulated.seed = seed;
  const Simulation simulation(simulated);
  const Scene scene = load_scene(simulated.scene);
  const RayCaster caster(scene);
  const RgbdCalibration& calibration = simulation.calibration();
  FramePlaneFinder finder(calibration);
  PlaneMap map;
  DepthFilter filter(calibration);
  RangeError range_error(calibration, {});
  TruePlanes planes;
  int frames = 0;
  for (Utime t = simulation.start(); t < simulation.end(); t += 400'000) {
    RgbdFrame frame = simulation.render(t);
    filter(frame.depth, frame.amplitude);
    range_error.learn(frame.depth, frame.depth_utime);
    range_error.correct(frame.depth);
    const Eigen::Isometry3d T_world_depth =
        simulation.T_world_robot(calibration.depth_time(frame.depth_utime)) * calibration.T_robot_camera *
        calibration.T_colour_depth;
    map.insert(finder(frame.depth), finder.cells(), T_world_depth);
    add_seen(caster, scene, calibration, options.range, T_world_depth, frames++, planes);
  }
  const std::vector<PlanePatch> patches = map.patches();
  int of = 0, found = 0;
  std::vector<double> angles, offsets;
  Told tilts, distances;
  for (const auto& [key, plane] : planes) {
    const std::vector<Eigen::Vector3d> points = plane.points();
    if (static_cast<double>(points.size()) * cell * cell < options.area) continue;
    ++of;
    PlaneFit fit;
    const double share = covered(plane, points, patches, fit);
    const double angle = std::acos(std::min(1.0, fit.plane.normal.dot(plane.normal))) * 57.29578;
    if (share < 0.8 || angle > 1) {
      std::printf(
          "      missed: normal %5.2f %5.2f %5.2f offset %6.3f, %.2f m^2, %.0f %% covered, %.1f degrees\n",
          plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset,
          static_cast<double>(points.size()) * cell * cell, 100 * share, angle);
      continue;
    }
    ++found;
    angles.push_back(angle);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : points) middle += p / static_cast<double>(points.size());
    offsets.push_back(1000 * std::abs(fit.plane.distance(middle)));
    compare(plane, fit, tilts, distances);
  }
  const auto share_of = [](std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0
                          : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  std::printf("%4d %6d %6d %8.1f %8.2f %8.2f %8.1f %8.1f %8zu   %s   %s\n", static_cast<int>(seed), of, found,
              100.0 * found / std::max(of, 1), share_of(angles, 0.5), share_of(angles, 0.95),
              share_of(offsets, 0.5), share_of(offsets, 0.95), patches.size(), text(tilts).c_str(),
              text(distances).c_str());
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  CLI::App app("The planes of a simulated room against the truth");
  lcmslam::Options options;
  app.add_option("--scene", options.scene, "of config/scenes");
  app.add_option("--head", options.head, "rgbd or tof");
  app.add_option("--seeds", options.seeds, "how many");
  app.add_option("--seed", options.seed, "the first of them");
  app.add_option("--area", options.area, "m^2 that were seen of a plane that counts");
  app.add_option("--range", options.range, "m within which it was seen");
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "seed planes  found        %%   median/degree p95   median/mm p95  patches   tilts in 3 sigma, RMS   "
      "distances\n");
  for (int seed = options.seed; seed < options.seed + options.seeds; ++seed)
    lcmslam::run(options, static_cast<std::uint64_t>(seed));
}

// How often a view is found in a map, and how often in the wrong place (lcmslam::PlaceIndex).
//   build/release/bin/places_quality [--views 200] [--head rgbd] [--recording ../shared/data/tum_fr1_rpy]
//
// Simulated scenes: the map is made of keyframes along the robot's path; views are random poses beside it
// (within 0.4 m, 25 degrees), of which at least half look at what was mapped. "right" is within 5 cm and 2
// degrees of the truth, "false" another answer. "strangers" are views of the other scenes, asked in this
// one's map, and "twins" views in a map of two rooms that are the same: every answer to those is false.
// "beside an altered copy": the map has the same room a second time, without a third of its things. A
// recording's first half is its map, frames of the second half ask.

#include <array>
#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/places/place_index.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/rgbd/rgbd_frame_maker.hpp>
#include <lcmslam/simulation/colour_camera.hpp>
#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/sensor_head.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tests/bench/cpu_time.hpp"
#include "tests/bench/truth_fit.hpp"

namespace lcmslam {
namespace {

struct View {
  Eigen::Isometry3d T_world_camera;
  FeatureFrame features;
  ColouredCloud cloud;
};

/// As the graph makes them of a frame.
class ViewMaker {
 public:
  explicit ViewMaker(const RgbdCalibration& calibration)
      : calibration_(calibration), registration_(calibration), maker_({}) {
    SurfSettings settings;
    settings.hessian_threshold = 5;
    settings.budget.max_features = 600;
    surf_ = std::make_unique<Surf>(settings);
    maker_.calibrate(calibration);
  }
  View operator()(const RgbdFrame& frame, const Eigen::Isometry3d& T_world_camera,
                  const RgbdFrameMaker::MotionBetween& motion_between) {
    maker_.add(describe_frame(frame, registration_(frame), calibration_, *surf_));
    RgbdFrameMaker::Prepared prepared = maker_.prepare(frame);
    const auto made = maker_.make(prepared, motion_between, frame.utime - 30'000);
    return {T_world_camera, made.frame.features.value_or(FeatureFrame()), made.frame.colouriser()};
  }

 private:
  RgbdCalibration calibration_;
  DepthRegistration registration_;
  RgbdFrameMaker maker_;
  std::unique_ptr<Surf> surf_;
};

bool has_moved(const std::vector<View>& views, const Eigen::Isometry3d& T, double distance, double angle) {
  return views.empty() || distance_between(views.back().T_world_camera, T) >= distance ||
         angle_between(views.back().T_world_camera, T) >= angle;
}

class Room {
 public:
  Room(Scene scene, const std::string& head)
      : scene_(std::move(scene)),
        caster_(scene_),
        head_(make_head(head, scene_, caster_)),
        colour_(scene_, caster_, head_.calibration.colour),
        path_(control_points(scene_, 1)),
        make_(head_.calibration) {}

  /// Keyframes along the path.
  std::vector<View> keyframes() {
    std::vector<View> views;
    for (double t = 0; t < path_.duration(); t += 0.1) {
      const Eigen::Isometry3d T = path_.pose(t) * head_.calibration.T_robot_camera;
      if (has_moved(views, T, 0.25, 0.25)) views.push_back(look(T));
    }
    return views;
  }
  /// Random poses beside the path that look at what the keyframes have seen.
  std::vector<View> askers(int count, const std::vector<View>& keyframes) {
    std::vector<Eigen::Vector3f> mapped;
    for (const View& view : keyframes)
      for (std::size_t i = 0; i < view.cloud.size(); i += 7)
        mapped.push_back(view.T_world_camera.cast<float>() * view.cloud.points[i]);
    const KdTree tree(mapped);
    std::vector<View> views;
    Random random(7);
    while (static_cast<int>(views.size()) < count) {
      Vector6d offset;
      offset << random.uniform(-0.4, 0.4), random.uniform(-0.15, 0.15), random.uniform(-0.4, 0.4),
          random.uniform(-0.15, 0.15), random.uniform(-0.44, 0.44), random.uniform(-0.1, 0.1);
      const Eigen::Isometry3d T = path_.pose(random.uniform(0, path_.duration())) *
                                  head_.calibration.T_robot_camera * se3_exp(offset);
      if (caster_.distance(T.translation()) < 0.3) continue;
      const View view = look(T);
      std::size_t known = 0, points = 0;
      for (std::size_t i = 0; i < view.cloud.size(); i += 17, ++points)
        known += tree.nearest_few(T.cast<float>() * view.cloud.points[i], 1)[0].squared_distance < 0.01F;
      if (2 * known >= points && points > 0) views.push_back(view);
    }
    return views;
  }

 private:
  View look(const Eigen::Isometry3d& T) {
    RgbdFrame frame;
    frame.utime = ++time_;
    frame.depth_utime = frame.utime;
    frame.colour = colour_.render(T, PixelNoise(1, 1, time_), 2);
    head_.depth->render(T * head_.calibration.T_colour_depth, PixelNoise(1, 2, time_), 2, frame);
    return make_(frame, T, [](Utime, Utime) { return Motion(); });
  }

  Scene scene_;
  RayCaster caster_;
  SensorHead head_;
  ColourCamera colour_;
  PlanarPath path_;
  ViewMaker make_;
  Utime time_ = 0;
};

Scene load(const std::string& name) {
  return load_scene("config/scenes/" + name + ".yaml");
}

/// The scene without a third of its things; a thing is what stands in one 40 cm cell of the floor.
Scene changed(Scene scene) {
  std::vector<SceneTriangle> kept;
  for (const SceneTriangle& t : scene.triangles) {
    const Eigen::Vector3f centre = (t.corner[0] + t.corner[1] + t.corner[2]) / 3;
    const auto cell = [](float x) { return static_cast<std::uint64_t>(std::floor(x / 0.4F) + 1000); };
    Random random(3, 10'000 * cell(centre.x()) + cell(centre.y()));
    if (t.kind != SurfaceKind::object || random.uniform() > 0.33) kept.push_back(t);
  }
  scene.triangles = std::move(kept);
  return scene;
}

void add(PlaceIndex& places, const std::vector<View>& views,
         const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity()) {
  for (const View& view : views)
    places.add(static_cast<std::int64_t>(places.size()), T * view.T_world_camera, view.features, view.cloud);
}

void ask(const char* what, PlaceIndex& places, const std::vector<View>& askers, bool known) {
  int right = 0, wrong = 0;
  std::map<std::string, int> why;
  std::vector<double> times, errors, squares;
  for (const View& asker : askers) {
    const double begin = cpu_milliseconds();
    const Located located = places.locate(asker.features, asker.cloud);
    times.push_back(cpu_milliseconds() - begin);
    if (!located.place) {
      std::string reason = located.why_not;
      for (char& c : reason)
        if (c >= '0' && c <= '9') c = '#';
      ++why[reason];
      continue;
    }
    const Eigen::Isometry3d error = asker.T_world_camera.inverse() * located.place->T_map_camera;
    const bool near = error.translation().norm() < 0.05 && rotation_angle(error) < 2 * M_PI / 180;
    known&& near ? ++right : ++wrong;
    if (known && !near)
      std::printf("  off by %.3f m, %.2f deg (sigma %.3f m): %s\n", error.translation().norm(),
                  rotation_angle(error) * 180 / M_PI,
                  std::sqrt(located.place->covariance.diagonal().head<3>().sum()),
                  to_string(located.evidence).c_str());
    errors.push_back(1000 * error.translation().norm());
    const Vector6d xi = se3_log(error);
    squares.push_back(xi.dot(located.place->covariance.inverse() * xi) / 6);
  }
  std::printf("%-24s %4zu asked, %4d right (%5.1f %%), %d false; %.0f ms (p95 %.0f)", what, askers.size(),
              right, 100.0 * right / static_cast<double>(askers.size()), wrong, quantile(times, 0.5),
              quantile(times, 0.95));
  if (!errors.empty() && known)
    std::printf("; error %.1f mm (p95 %.1f), NEES/6 %.2f", quantile(errors, 0.5), quantile(errors, 0.95),
                quantile(squares, 0.5));
  std::printf("\n");
  for (const auto& [reason, count] : why) std::printf("  %4d x %s\n", count, reason.c_str());
}

void ask_simulated(int views, const std::string& head) {
  const std::array<const char*, 3> names = {"kitchen", "table", "office"};
  std::array<std::vector<View>, 3> keyframes, askers, altered;
  for (std::size_t i = 0; i < names.size(); ++i) {
    Room room(load(names[i]), head);
    keyframes[i] = room.keyframes();
    askers[i] = room.askers(views, keyframes[i]);
    altered[i] = Room(changed(load(names[i])), head).keyframes();
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    PlaceIndex places, twins;
    add(places, keyframes[i]);
    std::printf("%s: %zu keyframes, %.1f MB\n", names[i], keyframes[i].size(),
                1e-6 * static_cast<double>(places.memory_bytes()));
    ask(names[i], places, askers[i], true);
    std::vector<View> strangers;
    for (std::size_t other = 0; other < names.size(); ++other)
      if (other != i) strangers.insert(strangers.end(), askers[other].begin(), askers[other].end());
    ask("  strangers", places, strangers, false);
    PlaceIndex alike;
    add(alike, keyframes[i]);
    add(alike, altered[i], Eigen::Isometry3d(Eigen::Translation3d(20, 0, 0)));
    ask("  beside an altered copy", alike, askers[i], true);
    add(twins, keyframes[i]);
    add(twins, keyframes[i], Eigen::Isometry3d(Eigen::Translation3d(20, 0, 0)));
    ask("  twins", twins, askers[i], false);
  }
}

/// `clock_offset`, s: what the truth's clock shows more than the camera's. `fit`: poses by which that and the
/// place of the camera on the truth's body are found; empty: they are what the recording says.
void ask_recorded(int count, const std::string& folder, const std::string& poses, double clock_offset,
                  const std::string& fit) {
  const auto source = open_dataset(folder);
  const RgbdCalibration& calibration = source->calibration();
  Trajectory truth = poses.empty() ? source->truth() : read_pose_text(poses).trajectory;
  Eigen::Isometry3d T_truth_camera = poses.empty() && source->truth_frame() == "camera"
                                         ? Eigen::Isometry3d::Identity()
                                         : calibration.T_robot_camera;
  if (!fit.empty()) {
    const Trajectory camera = in_other_frame(read_pose_text(fit).trajectory, calibration.T_robot_camera);
    const TruthFit found = fit_truth(truth, camera, T_truth_camera);
    const Eigen::Isometry3d moved = T_truth_camera.inverse() * found.T_truth_camera;
    std::printf(
        "the truth's clock is %+.0f ms off, its body %.2f deg and %.1f mm; left: %.1f mm, %.2f deg RMS\n",
        1000 * found.clock_offset, rotation_angle(moved) * 180 / M_PI, 1000 * moved.translation().norm(),
        1000 * found.rms_translation, found.rms_rotation * 180 / M_PI);
    clock_offset = found.clock_offset;
    T_truth_camera = found.T_truth_camera;
  }
  for (auto& pose : truth) pose.utime -= std::llround(1e6 * clock_offset);
  ViewMaker make(calibration);
  const auto motion_between = [&](Utime from, Utime to) -> std::optional<Motion> {
    const auto a = pose_at(truth, from), b = pose_at(truth, to);
    if (!a || !b) return std::nullopt;
    Motion motion;
    motion.T_from_to = calibration.T_robot_camera * (*a * T_truth_camera).inverse() * *b * T_truth_camera *
                       calibration.T_robot_camera.inverse();
    return motion;
  };
  std::vector<View> keyframes, askers;
  const std::size_t half = source->size() / 2;
  const std::size_t step = std::max<std::size_t>(1, half / static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < source->size(); ++i) {
    const auto T_truth = pose_at(truth, source->entry(i).utime);
    if (!T_truth) continue;
    const Eigen::Isometry3d T = *T_truth * T_truth_camera;
    const bool maps = i < half;
    if (maps ? !has_moved(keyframes, T, 0.15, 0.15) : (i - half) % step != 0) continue;
    const auto encoded = source->frame(i);
    if (encoded) (maps ? keyframes : askers).push_back(make(decode(*encoded), T, motion_between));
  }
  PlaceIndex places;
  add(places, keyframes);
  std::printf("%s: %zu keyframes of its first half\n", folder.c_str(), keyframes.size());
  ask("  second half", places, askers, true);
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  int views = 200;
  double clock_offset = 0;
  std::string head = "rgbd", recording, poses, fit;
  CLI::App app("How often a view is found in a map");
  app.add_option("--views", views, "of each scene");
  app.add_option("--head", head)->check(CLI::IsMember({"tof", "rgbd"}));
  app.add_option("--recording", recording, "a folder that lcmslam import reads, in the place of the scenes");
  app.add_option("--poses", poses, "the robot's poses that count as true, in the place of the recording's");
  app.add_option("--clock-offset", clock_offset, "s, of those poses' clock, as lcmslam evaluate finds it");
  app.add_option(
      "--fit", fit,
      "poses of the robot over the whole recording, by which the clock and the body of its truth are "
      "fitted");
  CLI11_PARSE(app, argc, argv);
  try {
    recording.empty() ? lcmslam::ask_simulated(views, head)
                      : lcmslam::ask_recorded(views, recording, poses, clock_offset, fit);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

// How often a new session of FastSLAM is joined to an old map of landmarks, and how often falsely
// (lcmslam::LandmarkJoiner).
//   build/release/bin/session_joins FOLDER [--seeds 2] [--seconds 0] [--verbose]
//
// Simulated drives through each scene, with other errors of the sensors for each seed, go through surf,
// odometry and FastSLAM: whole, and each part of them as a session of its own that begins anywhere, as when
// the robot was carried between. The maps are kept in FOLDER and made where they are not there. Then each
// session of one seed is looked for in the whole map of another. "right" is within 5 cm and 2 degrees of the
// truth, at the middle of the session's path, each map laid on the truth by its own path; "false" another
// answer, none of which may be. Strangers are sessions of other scenes; twins a map of two rooms that are the
// same, where every answer would be a guess; an altered copy is a room a second time, without a third of its
// landmarks (those of one 40 cm cell of the floor go together).

#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/places/landmark_joiner.hpp>
#include "procs/camera/camera_source.hpp"
#include "tests/bench/cpu_time.hpp"
#include "tools/study/report/mapping_run.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr double pi = M_PI;

struct Part {
  std::string name;
  double from, to;  // share of the drive's time
};
const std::vector<Part> parts = {{"whole", 0, 1},         {"first", 0, 0.34},   {"second", 0.33, 0.67},
                                 {"third", 0.66, 1},      {"start", 0, 0.5},    {"end", 0.5, 1},
                                 {"quarter2", 0.25, 0.5}, {"quarter4", 0.75, 1}};
const std::vector<std::string> scenes = {"kitchen", "table", "office"};

struct Session {
  std::string scene, part;
  int seed = 0;
  std::vector<Landmark> landmarks;
  Trajectory path, truth;

  Eigen::Isometry3d T_world_session() const { return fit_to_truth(truth, path); }
};

Drive part_of(const Drive& drive, const Part& part) {
  Drive cut = drive;
  cut.messages.clear();
  const double first = 1e-6 * static_cast<double>(drive.messages.front().utime);
  std::optional<BatchMessage> calibration;
  for (const BatchMessage& message : drive.messages) {
    if (message.channel == "CAMERA_CALIBRATION") calibration = message;
    const double at = (1e-6 * static_cast<double>(message.utime) - first) / drive.seconds;
    if (at < part.from || at > part.to) continue;
    if (cut.messages.empty() && calibration) cut.messages.push_back(*calibration);
    cut.messages.push_back(message);
  }
  return cut;
}

void save(const fs::path& file, const MappingRun& run, const Drive& drive) {
  fs::remove(file);
  MapStore store(file);
  Transaction transaction = store.begin();
  StoredSession session{0, "fastslam", 1, "map"};
  session.id = store.add_session(store.add_run({"simulated", ""}), session);
  SessionChanges changes;
  for (const Landmark& landmark : run.landmarks) changes.put_landmark(landmark);
  for (const StampedPose& pose : run.fastslam) changes.append_pose({pose.utime, pose.T_world_body});
  store.write(session.id, changes);
  transaction.commit();
  save_tum(fs::path(file).replace_extension(".tum"), drive.truth, {"world", "robot"});
}

void make_maps(const fs::path& folder, const std::string& scene, int seed, double seconds) {
  const auto file = [&](const Part& part) {
    return folder / (scene + "-" + std::to_string(seed) + "-" + part.name + ".lcmslam");
  };
  std::optional<Drive> drive;
  for (const Part& part : parts) {
    if (fs::exists(file(part)) && fs::exists(file(part).replace_extension(".tum"))) continue;
    if (!drive) {
      SimulationSourceSettings source;
      source.simulation.scene = share_path("config/scenes/" + scene + ".yaml");
      source.simulation.seed = static_cast<std::uint64_t>(seed);
      source.simulation.frame_rate = 5;
      source.simulation.seconds = seconds;
      drive = take_drive(*make_live_simulation(source));
    }
    MapperChoice choice;
    choice.icp = false;
    choice.seed = seed;
    const MappingRun run = map_drive(part_of(*drive, part), choice);
    save(file(part), run, *drive);
    std::printf("made %s: %zu landmarks of %.0f s\n", file(part).filename().c_str(), run.landmarks.size(),
                drive->seconds * (part.to - part.from));
    std::fflush(stdout);
  }
}

Session load(const fs::path& folder, const std::string& scene, int seed, const std::string& part) {
  const fs::path file = folder / (scene + "-" + std::to_string(seed) + "-" + part + ".lcmslam");
  Session session{scene, part, seed, {}, {}, read_tum(fs::path(file).replace_extension(".tum"))};
  MapFile map(file);
  session.landmarks = map.landmarks(1);
  for (const StoredPose& pose : map.trajectory(1)) session.path.push_back({pose.utime, pose.T_map_robot});
  return session;
}

/// Without a third of its landmarks.
std::vector<Landmark> altered(const std::vector<Landmark>& landmarks) {
  std::vector<Landmark> kept;
  for (const Landmark& l : landmarks) {
    const auto cell = [](double x) { return static_cast<std::uint64_t>(std::floor(x / 0.4) + 1000); };
    Random random(3, 10'000 * cell(l.mean.x()) + cell(l.mean.y()));
    if (random.uniform() > 0.33) kept.push_back(l);
  }
  return kept;
}

struct Count {
  int asked = 0, right = 0, wrong = 0;
  std::vector<double> distances, angles, squares, milliseconds;
};

struct Bench {
  bool verbose = false;

  /// `T_world_map` nothing: every answer is false.
  void ask(LandmarkPlaces& map, const std::optional<Eigen::Isometry3d>& T_world_map, const Session& session,
           const std::string& what, Count& count) const {
    LandmarkJoiner joiner;
    const double begin = cpu_milliseconds();
    joiner.add_all(session.landmarks, map);
    count.milliseconds.push_back(cpu_milliseconds() - begin);
    ++count.asked;
    std::string outcome = "-";
    if (joiner.joint()) {
      const Joint& joint = *joiner.joint();
      double distance = 1e9, angle = 1e9;
      if (T_world_map) {
        const StampedPose& middle = session.path[session.path.size() / 2];
        const Eigen::Isometry3d truth = session.T_world_session() * middle.T_world_body;
        const Eigen::Isometry3d said = *T_world_map * joint.T_map_session * middle.T_world_body;
        distance = distance_between(truth, said);
        angle = angle_between(truth, said);
        count.distances.push_back(1000 * distance);
        count.angles.push_back(angle * 180 / pi);
        const Vector6d xi =
            se3_log(joint.T_map_session.inverse() * T_world_map->inverse() * session.T_world_session());
        count.squares.push_back(xi.dot(joint.covariance.inverse() * xi) / 6);
      }
      const bool right = distance < 0.05 && angle < 2 * pi / 180;
      ++(right ? count.right : count.wrong);
      char text[200];
      std::snprintf(text, sizeof text, "%s %.3f m %.2f deg: %s", right ? "right" : "FALSE", distance,
                    angle * 180 / pi, to_string(joint).c_str());
      outcome = text;
    }
    if (verbose || outcome.find("FALSE") == 0)
      std::printf("    %s in %s: %s\n",
                  (session.scene + "-" + std::to_string(session.seed) + "-" + session.part).c_str(),
                  what.c_str(), outcome.c_str());
    if (verbose) groups(map, T_world_map, session);
  }

  static void groups(LandmarkPlaces& map, const std::optional<Eigen::Isometry3d>& T_world_map,
                     const Session& session) {
    for (std::size_t i = 0; i + LandmarkJoiner::group_size <= session.landmarks.size();
         i += LandmarkJoiner::group_size) {
      const auto begin = session.landmarks.begin() + static_cast<std::ptrdiff_t>(i);
      const LocatedGroup g = map.locate({begin, begin + LandmarkJoiner::group_size});
      std::printf("      %3zu: %2d (other %2d) share %.2f %s", i, g.inliers, g.other_inliers, g.share,
                  g.why_not.c_str());
      if (g.place && T_world_map) {
        const Eigen::Isometry3d truth = session.T_world_session() * g.T_session_group;
        const Eigen::Isometry3d said = *T_world_map * g.place->T_map_camera;
        std::printf(" off %.3f m %.2f deg", distance_between(truth, said),
                    angle_between(truth, said) * 180 / pi);
      }
      std::printf("\n");
    }
  }
};

void print(const std::string& what, Count& c) {
  std::printf("%-30s %4d asked, %4d right (%5.1f %%), %d false; %.0f ms (p95 %.0f)", what.c_str(), c.asked,
              c.right, c.asked > 0 ? 100.0 * c.right / c.asked : 0.0, c.wrong, quantile(c.milliseconds, 0.5),
              quantile(c.milliseconds, 0.95));
  if (!c.distances.empty())
    std::printf("; error %.0f mm (p95 %.0f), %.2f deg (p95 %.2f), NEES/6 %.2f", quantile(c.distances, 0.5),
                quantile(c.distances, 0.95), quantile(c.angles, 0.5), quantile(c.angles, 0.95),
                quantile(c.squares, 0.5));
  std::printf("\n");
  std::fflush(stdout);
}

void measure(const fs::path& folder, int seeds, bool verbose) {
  std::map<std::string, std::vector<Session>> sessions;
  for (const std::string& scene : scenes)
    for (int seed = 1; seed <= seeds; ++seed)
      for (const Part& part : parts) sessions[scene].push_back(load(folder, scene, seed, part.name));
  const Bench bench{verbose};
  for (const std::string& scene : scenes) {
    Count alone, beside, twins, strangers;
    for (const Session& old : sessions[scene]) {
      if (old.part != "whole") continue;
      LandmarkPlaces map, copy, twin;
      map.add(old.landmarks);
      const Eigen::Isometry3d there(Eigen::Translation3d(20, 0, 0));
      copy.add(old.landmarks);
      copy.add(altered(old.landmarks), there);
      twin.add(old.landmarks);
      twin.add(old.landmarks, there);
      const Eigen::Isometry3d T_world_map = old.T_world_session();
      const std::string name = scene + "-" + std::to_string(old.seed);
      for (const Session& session : sessions[scene]) {
        if (session.seed == old.seed) continue;
        bench.ask(map, T_world_map, session, name, alone);
        Bench quiet;
        quiet.ask(copy, T_world_map, session, name + " beside an altered copy", beside);
        quiet.ask(twin, std::nullopt, session, name + " twice", twins);
      }
      for (const auto& [other, all] : sessions) {
        if (other == scene) continue;
        for (const Session& session : all) Bench().ask(map, std::nullopt, session, name, strangers);
      }
    }
    print(scene, alone);
    print("  beside an altered copy", beside);
    print("  twins", twins);
    print("  strangers", strangers);
  }
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  std::string folder;
  int seeds = 2;
  double seconds = 0;
  bool verbose = false;
  CLI::App app("How often a session of FastSLAM is joined to an old map of landmarks");
  app.add_option("folder", folder, "that takes the maps, made where it is missing")->required();
  app.add_option("--seeds", seeds, "of the sensors' errors, drives through each scene")
      ->check(CLI::Range(2, 100));
  app.add_option("--seconds", seconds, "of each drive, where maps are made; 0: the whole path");
  app.add_flag("--verbose", verbose, "a line for each session and each group of landmarks");
  CLI11_PARSE(app, argc, argv);
  try {
    std::filesystem::create_directories(folder);
    for (const std::string& scene : lcmslam::scenes)
      for (int seed = 1; seed <= seeds; ++seed) lcmslam::make_maps(folder, scene, seed, seconds);
    lcmslam::measure(folder, seeds, verbose);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

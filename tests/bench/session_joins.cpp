// How often a new session of FastSLAM is joined to an old map of landmarks, and how often falsely
// (lcmslam::LandmarkJoiner).
//   lcmslam simulate config/scenes/kitchen.yaml kitchen-41.lcmlog --seed 41
//   lcmslam batch kitchen-41.lcmlog --out kitchen-41
//   build/release/bin/session_joins FOLDER kitchen-41:kitchen-41.lcmlog:kitchen-41/batch.lcmlog ...
//   [--verbose]
//
// Drives through scenes, with other errors of the sensors for each seed; a drive's name is SCENE-SEED. Its
// FEATURES and ODOMETRY go through FastSLAM: whole, and each part of them as a session of its own that begins
// anywhere, as when the robot was carried between. The maps are kept in FOLDER and made where they are not
// there. Then each session of one seed is looked for in the whole map of another. "right" is within 5 cm and
// 2 degrees of the truth, at the middle of the session's path, each map laid on the truth by its own path;
// "false" another answer, none of which may be. Strangers are sessions of other scenes; twins a map of two
// rooms that are the same, where every answer would be a guess; an altered copy is a room a second time,
// without a third of its landmarks (those of one 40 cm cell of the floor go together).

#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/ground_truth_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/places/landmark_joiner.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "tests/bench/cpu_time.hpp"
#include "tests/bench/truth_fit.hpp"

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

struct Drive {
  std::string name, log, results;

  explicit Drive(const std::string& told) {
    const auto first = told.find(':'), second = told.find(':', first + 1);
    if (second == std::string::npos)
      throw std::invalid_argument(told +
                                  ": must be SCENE-SEED:LOG:RESULTS, as kitchen-1:a.lcmlog:a/batch.lcmlog");
    name = told.substr(0, first);
    log = told.substr(first + 1, second - first - 1);
    results = told.substr(second + 1);
  }
  std::string scene() const { return name.substr(0, name.find('-')); }
};

struct Session {
  std::string scene, drive, part;
  std::vector<Landmark> landmarks;
  Trajectory path;
  Eigen::Isometry3d T_world_session = Eigen::Isometry3d::Identity();
};

/// Keeps the map that FastSLAM tells.
class Listener : public Publisher {
 public:
  Listener() : Publisher(1) {}
  LandmarkMap map;
  Trajectory path;

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime) override {
    if (channel == "FASTSLAM_POSE") {
      const auto m = decode_message<pose_estimate_t>(bytes.data(), bytes.size());
      path.push_back({m.utime, from_message(m.T_map_robot, "T_map_robot")});
    } else if (channel == "FASTSLAM_LANDMARKS") {
      const auto m = decode_message<landmarks_t>(bytes.data(), bytes.size());
      map.apply({m.map_revision, m.base_revision, landmarks_of(m), m.removed});
    }
  }
};

Trajectory truth_of(const Drive& drive) {
  Trajectory truth;
  LogReader reader(drive.log);
  while (const auto event = reader.next()) {
    if (event->channel != "GROUND_TRUTH") continue;
    const auto m = decode_message<ground_truth_t>(event->data.data(), event->data.size());
    if (m.child_frame != "robot") throw std::runtime_error(drive.log + ": has no truth of the robot");
    truth.push_back({m.utime, from_message(m.T_frame_child, "T_frame_child")});
  }
  sort_trajectory(truth);
  return truth;
}

void make_map(const Drive& drive, const Part& part, const fs::path& file) {
  const Trajectory truth = truth_of(drive);
  const auto begin = static_cast<double>(truth.front().utime);
  const double length = static_cast<double>(truth.back().utime) - begin;
  Listener listener;
  FastSlamNode node(ConfigNode::parse("{}"), listener);
  Inputs inputs;
  node.connect(inputs);
  LogReader reader(drive.results);
  while (const auto event = reader.next()) {
    const double at = (static_cast<double>(event->timestamp) - begin) / length;
    if ((event->channel == "FEATURES" || event->channel == "ODOMETRY") && at >= part.from && at <= part.to)
      inputs.deliver(event->channel, event->data.data(), event->data.size());
  }
  node.finish();
  fs::remove(file);
  MapStore store(file);
  Transaction transaction = store.begin();
  StoredSession session{0, "fastslam", 1, "map"};
  session.id = store.add_session(store.add_run({"simulated", ""}), session);
  SessionChanges changes;
  for (const Landmark& landmark : listener.map.landmarks()) changes.put_landmark(landmark);
  for (const StampedPose& pose : listener.path) changes.append_pose({pose.utime, pose.T_world_body});
  store.write(session.id, changes);
  transaction.commit();
  save_tum(fs::path(file).replace_extension(".tum"), truth, {"world", "robot"});
  std::printf("made %s: %zu landmarks of %.0f s\n", file.filename().c_str(), listener.map.size(),
              1e-6 * length * (part.to - part.from));
}

Session load(const fs::path& folder, const Drive& drive, const Part& part) {
  const fs::path file = folder / (drive.name + "-" + part.name + ".lcmslam");
  if (!fs::exists(file) || !fs::exists(fs::path(file).replace_extension(".tum"))) make_map(drive, part, file);
  Session session{drive.scene(), drive.name, part.name, {}, {}};
  MapFile map(file);
  session.landmarks = map.landmarks(1);
  for (const StoredPose& pose : map.trajectory(1)) session.path.push_back({pose.utime, pose.T_map_robot});
  session.T_world_session = fit_world(read_tum(fs::path(file).replace_extension(".tum")), session.path);
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
        const Eigen::Isometry3d truth = session.T_world_session * middle.T_world_body;
        const Eigen::Isometry3d said = *T_world_map * joint.T_map_session * middle.T_world_body;
        distance = distance_between(truth, said);
        angle = angle_between(truth, said);
        count.distances.push_back(1000 * distance);
        count.angles.push_back(angle * 180 / pi);
        const Vector6d xi =
            se3_log(joint.T_map_session.inverse() * T_world_map->inverse() * session.T_world_session);
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
      std::printf("    %s in %s: %s\n", (session.drive + "-" + session.part).c_str(), what.c_str(),
                  outcome.c_str());
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
        const Eigen::Isometry3d truth = session.T_world_session * g.T_session_group;
        const Eigen::Isometry3d said = *T_world_map * g.place->T_map_camera;
        std::printf(" off %.3f m %.2f deg", distance_between(truth, said),
                    angle_between(truth, said) * 180 / pi);
      }
      std::printf("\n");
    }
  }
};

void print(const std::string& what, Count& c) {
  if (c.asked == 0) return;
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

void measure(const fs::path& folder, const std::vector<Drive>& drives, bool verbose) {
  std::map<std::string, std::vector<Session>> sessions;
  for (const Drive& drive : drives)
    for (const Part& part : parts) sessions[drive.scene()].push_back(load(folder, drive, part));
  const Bench bench{verbose};
  for (const auto& [scene, own] : sessions) {
    Count alone, beside, twins, strangers;
    for (const Session& old : own) {
      if (old.part != "whole") continue;
      LandmarkPlaces map, copy, twin;
      map.add(old.landmarks);
      const Eigen::Isometry3d there(Eigen::Translation3d(20, 0, 0));
      copy.add(old.landmarks);
      copy.add(altered(old.landmarks), there);
      twin.add(old.landmarks);
      twin.add(old.landmarks, there);
      const Eigen::Isometry3d T_world_map = old.T_world_session;
      const std::string& name = old.drive;
      for (const Session& session : own) {
        if (session.drive == old.drive) continue;
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
  std::vector<std::string> told;
  bool verbose = false;
  CLI::App app("How often a session of FastSLAM is joined to an old map of landmarks");
  app.add_option("folder", folder, "that takes the maps, made where it is missing")->required();
  app.add_option("drives", told, "SCENE-SEED:LOG:RESULTS")->required();
  app.add_flag("--verbose", verbose, "a line for each session and each group of landmarks");
  CLI11_PARSE(app, argc, argv);
  try {
    std::filesystem::create_directories(folder);
    lcmslam::measure(folder, {told.begin(), told.end()}, verbose);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

#include <fmt/format.h>
#include <algorithm>
#include <iostream>
#include <set>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/file/clear_beside.hpp>
#include <lcmslam/map_store/file/compact_map_file.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/places/landmark_joiner.hpp>
#include "tools/map/map_commands.hpp"
#include "tools/map/map_diff.hpp"
#include "tools/output_file.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

using Places = std::map<std::int64_t, Eigen::Isometry3d>;

/// A mapper's sessions whose place in its map's frame, that of the first, is known: by id.
Places placed_sessions(MapFile& map, const std::string& mapper) {
  Places places;
  for (const StoredSession& session : map.sessions()) {
    const SessionCounts counts = map.counts(session.id);
    if (session.mapper != mapper || counts.features + counts.landmarks == 0) continue;
    if (places.empty() || session.T_map_session)
      places[session.id] = session.T_map_session.value_or(Eigen::Isometry3d::Identity());
  }
  return places;
}

/// Calls `use` with each keyframe of those sessions that has features and a cloud, in the map's frame.
template <class Use>
void for_each_view(MapFile& map, const Use& use) {
  for (const auto& [session, T_map_session] : placed_sessions(map, "icp"))
    for (const StoredKeyframe& keyframe : map.keyframes(session)) {
      const auto features = map.features(session, keyframe.id);
      const auto cloud = map.cloud(session, keyframe.id);
      if (features && cloud) use(T_map_session * keyframe.T_map_camera, *features, *cloud);
    }
}

/// Where the second map lies in the first, by mapper; what is not certain is not there.
using Joints = std::map<std::string, Joint>;

void find_by_keyframes(MapFile& first, MapFile& second, Joints& joints) {
  PlaceIndex places;
  for_each_view(first,
                [&](const Eigen::Isometry3d& T, const FeatureFrame& features, const ColouredCloud& cloud) {
                  places.add(static_cast<std::int64_t>(places.size()), T, features, cloud);
                });
  SessionJoiner joiner;
  for_each_view(second,
                [&](const Eigen::Isometry3d& T, const FeatureFrame& features, const ColouredCloud& cloud) {
                  if (!joiner.done()) joiner.add(T, features, cloud, places);
                });
  if (joiner.joint()) joints["icp"] = *joiner.joint();
}

void find_by_landmarks(MapFile& first, MapFile& second, Joints& joints) {
  LandmarkPlaces places;
  for (const auto& [session, T_map_session] : placed_sessions(first, "fastslam"))
    places.add(first.landmarks(session), T_map_session);
  LandmarkJoiner joiner;
  for (const auto& [session, T_map_session] : placed_sessions(second, "fastslam")) {
    std::vector<Landmark> landmarks = second.landmarks(session);
    for (Landmark& landmark : landmarks) landmark = transformed(landmark, T_map_session);
    joiner.add_all(landmarks, places);
  }
  if (joiner.joint()) joints["fastslam"] = *joiner.joint();
}

/// Throws where nothing is certain.
Joints find_joints(MapFile& first, MapFile& second) {
  Joints joints;
  find_by_keyframes(first, second, joints);
  find_by_landmarks(first, second, joints);
  if (joints.empty())
    throw std::runtime_error(
        "the maps have no place in common that is certain enough, neither by keyframes nor by landmarks; "
        "nothing was written");
  return joints;
}

SessionChanges map_of(MapFile& map, std::int64_t session) {
  SessionChanges all;
  for (const StoredKeyframe& keyframe : map.keyframes(session)) {
    if (const auto cloud = map.cloud(session, keyframe.id))
      all.put_keyframe({keyframe.id, keyframe.utime, keyframe.T_map_camera, *cloud, 0}, keyframe.covariance);
    else
      all.move_keyframe(keyframe.id, keyframe.utime, keyframe.T_map_camera, keyframe.covariance);
    if (const auto features = map.features(session, keyframe.id)) all.put_features(keyframe.id, *features);
    if (auto images = map.images(session, keyframe.id)) all.put_images(keyframe.id, std::move(*images));
  }
  std::map<SessionChanges::Pair, std::vector<StoredEdge>> edges;
  for (const StoredEdge& edge : map.edges(session)) edges[{edge.from, edge.to}].push_back(edge);
  for (const auto& [pair, between] : edges) all.set_edges(pair, between);
  for (const Landmark& landmark : map.landmarks(session)) all.put_landmark(landmark);
  return all;
}

/// In parts: changes that wait are bounded, and thin poses out.
void copy_trajectory(MapFile& map, std::int64_t from, MapStore& store, std::int64_t to) {
  constexpr std::size_t a_part = 10'000;
  const std::vector<StoredPose> poses = map.trajectory(from);
  for (std::size_t begin = 0; begin < poses.size(); begin += a_part) {
    SessionChanges part;
    for (std::size_t i = begin; i < std::min(poses.size(), begin + a_part); ++i) part.append_pose(poses[i]);
    store.write(to, part);
  }
}

/// What says where a session of the second map lies in the first. One that had been joined before lies where
/// its own keyframes were found in a map that has its place now.
std::string evidence_of(const StoredSession& session, const Joint& joint) {
  if (!session.T_map_session || session.evidence.empty()) return to_string(joint);
  return session.evidence + "; the map in which they were found: " + to_string(joint);
}

/// Of its keyframes and poses; 0: it has none.
Utime newest(MapFile& map, std::int64_t session) {
  Utime newest = 0;
  for (const StoredKeyframe& keyframe : map.keyframes(session)) newest = std::max(newest, keyframe.utime);
  for (const StoredPose& pose : map.trajectory(session)) newest = std::max(newest, pose.utime);
  return newest;
}

/// Sessions that both files have, as they are in one file and in a copy that has grown since.
struct InBoth {
  std::set<std::int64_t> ids_in_second;
  std::string names;             ///< as the first calls them
  bool second_is_newer = false;  ///< or has all that the first has, and more sessions
};

/// Throws where each file has sessions that are newer than in the other.
InBoth sessions_in_both(MapFile& first, MapFile& second) {
  InBoth both;
  bool first_is_newer = false;
  for (const CommonSession& session : common_sessions(first, second)) {
    both.ids_in_second.insert(session.id_in_second);
    both.names += (both.names.empty() ? "" : ", ") + session.name;
    const Utime a = newest(first, session.id_in_first), b = newest(second, session.id_in_second);
    first_is_newer = first_is_newer || a > b;
    both.second_is_newer = both.second_is_newer || b > a;
  }
  if (first_is_newer && both.second_is_newer)
    throw std::runtime_error("sessions " + both.names +
                             " are in both maps, some newer in the first and some in the second; nothing was "
                             "written");
  const std::size_t n = both.ids_in_second.size();
  if (!first_is_newer && n > 0 && n == first.sessions().size() && n < second.sessions().size())
    both.second_is_newer = true;
  return both;
}

/// Of sessions that are in both.
bool is_newer(const fs::path& file, const fs::path& than) {
  MapFile a(than), b(file);
  return sessions_in_both(a, b).second_is_newer;
}

void append(MapFile& second, const std::set<std::int64_t>& known, const Joints& joints,
            const fs::path& file) {
  MapStore store(file);
  Transaction transaction = store.begin();
  std::int64_t run = 0;
  for (const StoredRun& written : second.runs()) run = store.add_run(written);
  for (const StoredCalibration& calibration : second.calibrations()) store.put_calibration(calibration);
  for (StoredSession session : second.sessions()) {
    if (known.count(session.id) > 0) continue;
    const std::int64_t old = session.id;
    const StoredSession before = session;
    session.id = store.add_session(run, session);
    store.write(session.id, map_of(second, old));
    copy_trajectory(second, old, store, session.id);
    const auto joint = joints.find(session.mapper);
    const Places places = placed_sessions(second, session.mapper);
    const auto place = places.find(old);
    session.state = SessionState::own_frame;
    session.T_map_session.reset();
    session.evidence.clear();
    if (joint != joints.end() && place != places.end()) {
      session.state = SessionState::joined;
      session.T_map_session = joint->second.T_map_session * place->second;
      session.evidence = evidence_of(before, joint->second);
    }
    store.place_session(session);
  }
  transaction.commit();
}

/// Both in one file, which takes its name when it is whole. The first has the sessions of the second that are
/// `known`; where those are all, it stays as it is.
void save_merged(const fs::path& first, const fs::path& second, const std::set<std::int64_t>& known,
                 const Joints& joints, const fs::path& into) {
  write_atomically(FilePlace(into), [&](const fs::path& link) {
    const fs::path part = fs::canonical(link);  // SQLite follows no links (Database)
    try {
      compact_into(first, part);
      MapFile added(second);
      if (known.size() < added.sessions().size()) append(added, known, joints, part);
      clear_beside(part);  // takes its log in, which a full disk lets nobody see when a database is closed
    } catch (...) {
      for (const char* ending : {"-wal", "-shm"}) fs::remove(part.string() + ending);
      throw;
    }
    clear_beside(into);
  });
}

std::string told(const std::string& mapper, const Joint& joint) {
  const Eigen::Vector3d at = joint.T_map_session.translation();
  return fmt::format("{}: the second lies at {:.3f} {:.3f} {:.3f} m, {:.2f} deg in the first: {}\n", mapper,
                     at.x(), at.y(), at.z(), yaw(joint.T_map_session) * 180 / M_PI, to_string(joint));
}

}  // namespace

int map_merge_command(int argc, char** argv) {
  std::string first, second, into;
  bool force = false;
  CLI::App app{
      "Joins two maps of one place: finds where the second lies in the first by what both saw, and writes "
      "the "
      "sessions of both into one file. Exit code 1, and no file, when that is not certain. A session that "
      "both have, as a map and a grown copy of it, goes in once, as the newer file has it, whose frame "
      "stays.",
      "lcmslam map merge"};
  app.add_option("first", first, "an .lcmslam file, whose frame stays")->required();
  app.add_option("second", second, "an .lcmslam file")->required();
  app.add_option("--into", into, "FILE: takes both")->type_name("FILE")->required();
  app.add_flag("--force", force, "overwrite that if it exists");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  check_output_file(into, force);
  Joints joints;
  InBoth both;
  const bool is_turned = is_newer(second, first);
  if (is_turned) std::swap(first, second);
  {
    MapFile a(first), b(second);  // closed before one of them is replaced
    both = sessions_in_both(a, b);
    if (both.names.empty() || both.ids_in_second.size() < b.sessions().size()) joints = find_joints(a, b);
  }
  save_merged(first, second, both.ids_in_second, joints, into);
  std::cout << into << "\n";
  if (!both.names.empty())
    std::cout << "in both maps, and taken as " << first << " has them: " << both.names << "\n";
  if (is_turned) std::cout << first << " is the newer one: it is called the first\n";
  for (const auto& [mapper, joint] : joints) std::cout << told(mapper, joint);
  return 0;
}

}  // namespace lcmslam

#include <lcmslam/map_store/file/map_file.hpp>

#include <limits>
#include <map>

#include <lcmslam/map_store/file/store_codecs.hpp>

namespace lcmslam {
namespace {

template <class Read>
void attempt(MapFile::Damage* damage, const Read& read) {
  try {
    read();
  } catch (const StoreError& error) {
    if (damage == nullptr) throw;
    damage->push_back(error.what());
  }
}

}  // namespace

std::vector<std::string> names_of(const std::vector<StoredSession>& sessions) {
  std::vector<std::string> names;
  names.reserve(sessions.size());
  std::map<std::string, int> numbers;
  for (const StoredSession& session : sessions)
    names.push_back(session.mapper + "-session" + std::to_string(++numbers[session.mapper]));
  return names;
}

bool may_be_there(const std::filesystem::path& file) {
  std::error_code unknown;
  return std::filesystem::exists(file, unknown) || unknown;
}

MapFile::MapFile(const std::filesystem::path& file, std::chrono::milliseconds patience)
    : database_(file, Database::Access::read, nullptr, patience), moment_(database_, "DEFERRED") {
  schema_ = schema_of(database_);
}

/// What `decode` gives; a blob that cannot be decoded is an error that names its row.
template <class Decode>
auto MapFile::decoded(const char* what, std::int64_t session, std::int64_t id, const Decode& decode) {
  try {
    return decode();
  } catch (const BlobError& error) {
    database_.fail(std::string(what) + " " + std::to_string(id) + " of session " + std::to_string(session) +
                   ": " + error.what());
  }
}

std::vector<StoredRun> MapFile::runs() {
  std::vector<StoredRun> runs;
  if (schema_ == 0) return runs;
  Statement rows(database_, "SELECT version, configuration FROM run ORDER BY id");
  while (rows.step()) runs.push_back({rows.text(0), rows.text(1)});
  return runs;
}

std::vector<StoredSession> MapFile::sessions(Damage* damage) {
  std::vector<StoredSession> sessions;
  if (schema_ == 0) return sessions;
  const std::string place = schema_ >= 2 ? "state, T_map_session, evidence" : "0, NULL, ''";
  Statement rows(database_, "SELECT id, mapper, sender, frame, " + place + " FROM session ORDER BY id");
  while (rows.step()) {
    StoredSession session{rows.integer(0), rows.text(1), rows.integer(2), rows.text(3)};
    attempt(damage, [&] {
      if (!rows.is_null(5))
        session.T_map_session =
            decoded("place", session.id, session.id, [&] { return decode_pose(rows.blob(5)); });
      session.state = rows.integer(4) == 1 ? SessionState::joined : SessionState::own_frame;
      session.evidence = rows.text(6);
    });
    sessions.push_back(session);
  }
  return sessions;
}

SessionCounts MapFile::counts(std::int64_t session) {
  const auto count = [&](const std::string& what) {
    Statement row(database_, "SELECT " + what + " WHERE session = ?");
    row(session).step();
    return row.integer(0);
  };
  return {count("count(*) FROM keyframe"),
          count("count(*) FROM cloud"),
          count("coalesce(sum(points), 0) FROM cloud"),
          count("count(*) FROM features"),
          schema_ >= 3 ? count("count(*) FROM images") : 0,
          count("count(*) FROM edge"),
          count("count(*) FROM landmark")};
}

std::optional<std::int64_t> MapFile::frame_session(const std::string& mapper) {
  std::optional<std::int64_t> first;
  Damage of_places;
  for (const StoredSession& session : sessions(&of_places)) {
    if (session.mapper != mapper) continue;
    if (!first) first = session.id;
    const SessionCounts has = counts(session.id);
    if (has.features + has.landmarks > 0) return session.id;
  }
  return first;
}

std::vector<StoredCalibration> MapFile::calibrations() {
  if (schema_ == 0) return {};
  Statement rows(database_, "SELECT sensor, form, data FROM calibration ORDER BY sensor");
  return read_calibrations(rows);
}

std::vector<StoredCalibration> MapFile::cameras() {
  if (schema_ < 4) return calibrations();
  Statement rows(database_, "SELECT sensor, form, data FROM camera ORDER BY id");
  return read_calibrations(rows);
}

std::vector<StoredCalibration> MapFile::read_calibrations(Statement& rows) {
  std::vector<StoredCalibration> calibrations;
  while (rows.step())
    calibrations.push_back({rows.text(0), rows.text(1),
                            decoded("calibration", 0, 0, [&] { return decode_bytes(rows.blob(2)); })});
  return calibrations;
}

std::vector<StoredKeyframe> MapFile::keyframes(std::int64_t session, Damage* damage) {
  std::vector<StoredKeyframe> keyframes;
  Statement rows(database_, "SELECT id, utime, pose, covariance FROM keyframe WHERE session = ? ORDER BY id");
  for (rows(session); rows.step();) attempt(damage, [&] { keyframes.push_back(keyframe_in(rows, session)); });
  return keyframes;
}

StoredKeyframe MapFile::keyframe_in(const Statement& row, std::int64_t session) {
  StoredKeyframe keyframe;
  keyframe.id = static_cast<std::int32_t>(row.integer(0));
  keyframe.utime = row.integer(1);
  keyframe.T_map_camera = decoded("keyframe", session, keyframe.id, [&] { return decode_pose(row.blob(2)); });
  if (!row.is_null(3))
    keyframe.covariance = decoded("covariance of keyframe", session, keyframe.id,
                                  [&] { return decode_covariance(row.blob(3)); });
  return keyframe;
}

std::vector<StoredEdge> MapFile::edges(std::int64_t session) {
  std::vector<StoredEdge> edges;
  Statement rows(database_,
                 "SELECT from_keyframe, to_keyframe, data FROM edge WHERE session = ? "
                 "ORDER BY from_keyframe, to_keyframe, number");
  for (rows(session); rows.step();) {
    edges.push_back(
        decoded("edge from keyframe", session, rows.integer(0), [&] { return decode_edge(rows.blob(2)); }));
    edges.back().from = static_cast<std::int32_t>(rows.integer(0));
    edges.back().to = static_cast<std::int32_t>(rows.integer(1));
  }
  return edges;
}

std::optional<ColouredCloud> MapFile::cloud(std::int64_t session, std::int32_t keyframe) {
  Statement row(database_, "SELECT data, points FROM cloud WHERE session = ? AND keyframe = ?");
  if (!row(session, static_cast<std::int64_t>(keyframe)).step()) return std::nullopt;
  return decoded("cloud of keyframe", session, keyframe, [&] {
    ColouredCloud cloud = decode_cloud(row.blob(0));
    if (static_cast<std::int64_t>(cloud.size()) != row.integer(1))
      throw BlobError("the row counts " + std::to_string(row.integer(1)) + " points, the blob has " +
                      std::to_string(cloud.size()));
    return cloud;
  });
}

std::optional<FeatureFrame> MapFile::features(std::int64_t session, std::int32_t keyframe) {
  Statement row(database_, "SELECT data FROM features WHERE session = ? AND keyframe = ?");
  if (!row(session, static_cast<std::int64_t>(keyframe)).step()) return std::nullopt;
  return decoded("features of keyframe", session, keyframe, [&] { return decode_features(row.blob(0)); });
}

std::optional<StoredImages> MapFile::images(std::int64_t session, std::int32_t keyframe) {
  if (schema_ < 3) return std::nullopt;
  const std::string camera_id = schema_ >= 4 ? "camera" : "0";
  Statement row(database_, "SELECT data, " + camera_id + " FROM images WHERE session = ? AND keyframe = ?");
  if (!row(session, static_cast<std::int64_t>(keyframe)).step()) return std::nullopt;
  StoredImages images =
      decoded("images of keyframe", session, keyframe, [&] { return decode_images(row.blob(0)); });
  if (row.is_null(1)) return images;
  images.calibration = row.integer(1) != 0 ? camera(row.integer(1)) : first_camera(images.frame.sensor);
  return images;
}

std::shared_ptr<const StoredCalibration> MapFile::camera(std::int64_t id) {
  Statement row(database_, "SELECT sensor, form, data FROM camera WHERE id = ?");
  const auto found = read_calibrations(row(id));
  if (found.empty()) database_.fail("there is no camera " + std::to_string(id));
  return std::make_shared<StoredCalibration>(found.front());
}

/// Of images from before schema 4.
std::shared_ptr<const StoredCalibration> MapFile::first_camera(const std::string& sensor) {
  const std::string cameras = schema_ >= 4 ? "camera WHERE is_first AND" : "calibration WHERE";
  Statement row(database_, "SELECT sensor, form, data FROM " + cameras + " " + is_of_sensor);
  const auto found = read_calibrations(row(sensor));
  return found.empty() ? nullptr : std::make_shared<StoredCalibration>(found.front());
}

DenseMap MapFile::dense_map(std::int64_t session) {
  constexpr std::size_t any = std::numeric_limits<std::size_t>::max() / 2;
  DenseMap map({any, any, 1});
  for (const StoredKeyframe& stored : keyframes(session)) {
    DenseKeyframe keyframe{stored.id, stored.utime, stored.T_map_camera, {}, 0};
    std::optional<ColouredCloud> points = cloud(session, stored.id);
    if (!points) continue;
    keyframe.cloud = std::move(*points);
    map.add({std::move(keyframe), 0, 1});
  }
  return map;
}

std::vector<Landmark> MapFile::landmarks(std::int64_t session) {
  std::vector<Landmark> landmarks;
  Statement rows(database_, "SELECT id, data FROM landmark WHERE session = ? ORDER BY id");
  for (rows(session); rows.step();)
    landmarks.push_back(decoded("landmark", session, rows.integer(0), [&] {
      const Landmark landmark = decode_landmark(rows.blob(1));
      if (landmark.id != rows.integer(0))
        throw BlobError("the blob is of landmark " + std::to_string(landmark.id));
      return landmark;
    }));
  return landmarks;
}

std::vector<StoredPose> MapFile::trajectory(std::int64_t session) {
  std::vector<StoredPose> trajectory;
  Statement rows(database_, "SELECT number, data FROM trajectory WHERE session = ? ORDER BY number");
  for (rows(session); rows.step();) {
    const auto poses = decoded("part of the trajectory", session, rows.integer(0),
                               [&] { return decode_trajectory(rows.blob(1)); });
    trajectory.insert(trajectory.end(), poses.begin(), poses.end());
  }
  return trajectory;
}

}  // namespace lcmslam

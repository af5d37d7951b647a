#include <lcmslam/map_store/file/map_store.hpp>

#include <lcmslam/map_store/file/store_codecs.hpp>

namespace lcmslam {
namespace {

/// Once the tables are there, so that the statements can be prepared.
Database open_for_writing(const std::filesystem::path& file, const char* vfs) {
  Database database(file, Database::Access::create, vfs);
  schema_of(database);  // a file that is none of ours is refused before anything of it changes
  database.execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL");
  migrate(database);
  database.note_written();
  return database;
}

}  // namespace

struct MapStore::Statements {
  explicit Statements(Database& d)
      : run(d, "INSERT INTO run(version, configuration) VALUES(?, ?)"),
        session(d, "INSERT INTO session(run, mapper, sender, frame) VALUES(?, ?, ?, ?)"),
        place(d, "UPDATE session SET state = ?, T_map_session = ?, evidence = ? WHERE id = ?"),
        calibration(d, "INSERT OR REPLACE INTO calibration(sensor, form, data) VALUES(?, ?, ?)"),
        keyframe(d,
                 "INSERT INTO keyframe(session, id, utime, pose, covariance) VALUES(?, ?, ?, ?, ?) "
                 "ON CONFLICT DO UPDATE SET utime = excluded.utime, pose = excluded.pose, "
                 "covariance = coalesce(excluded.covariance, covariance)"),
        cloud(d, "INSERT OR REPLACE INTO cloud(session, keyframe, points, data) VALUES(?, ?, ?, ?)"),
        // Features and images may come when their keyframe has gone already.
        features(d,
                 "INSERT OR REPLACE INTO features(session, keyframe, data) SELECT session, id, ?3 "
                 "FROM keyframe WHERE session = ?1 AND id = ?2"),
        images(d,
               "INSERT OR REPLACE INTO images(session, keyframe, data, camera) SELECT session, id, ?3, "
               "(SELECT id FROM camera WHERE sensor = ?4 AND form = ?5 AND data = ?6) "
               "FROM keyframe WHERE session = ?1 AND id = ?2"),
        camera(d,
               "INSERT INTO camera(sensor, form, data, is_first) SELECT ?1, ?2, ?3, 0 WHERE NOT EXISTS "
               "(SELECT 1 FROM camera WHERE sensor = ?1 AND form = ?2 AND data = ?3)"),
        copy_features(
            d,
            "INSERT OR IGNORE INTO features(session, keyframe, data) SELECT k.session, k.id, f.data "
            "FROM features f, keyframe k WHERE f.session = ?1 AND f.keyframe = ?3 AND k.session = ?2 "
            "AND k.id = ?3"),
        copy_images(d,
                    "INSERT OR IGNORE INTO images(session, keyframe, data, camera) SELECT k.session, k.id, "
                    "i.data, i.camera FROM images i, keyframe k WHERE i.session = ?1 AND i.keyframe = ?3 AND "
                    "k.session = ?2 AND k.id = ?3"),
        copy_covariance(d,
                        "UPDATE keyframe SET covariance = (SELECT covariance FROM keyframe WHERE session = "
                        "?1 AND id = ?3) WHERE session = ?2 AND id = ?3 AND covariance IS NULL"),
        drop_keyframe(d, "DELETE FROM keyframe WHERE session = ? AND id = ?"),
        drop_cloud(d, "DELETE FROM cloud WHERE session = ? AND keyframe = ?"),
        drop_features(d, "DELETE FROM features WHERE session = ? AND keyframe = ?"),
        drop_images(d, "DELETE FROM images WHERE session = ? AND keyframe = ?"),
        drop_edges_from(d, "DELETE FROM edge WHERE session = ? AND from_keyframe = ?"),
        drop_edges_to(d, "DELETE FROM edge WHERE session = ? AND to_keyframe = ?"),
        clear_edges(d, "DELETE FROM edge WHERE session = ?"),
        drop_pair(d, "DELETE FROM edge WHERE session = ? AND from_keyframe = ? AND to_keyframe = ?"),
        edge(d, "INSERT INTO edge(session, from_keyframe, to_keyframe, number, data) VALUES(?, ?, ?, ?, ?)"),
        clear_landmarks(d, "DELETE FROM landmark WHERE session = ?"),
        drop_landmark(d, "DELETE FROM landmark WHERE session = ? AND id = ?"),
        landmark(d,
                 "INSERT INTO landmark(session, id, data) VALUES(?, ?, ?) "
                 "ON CONFLICT DO UPDATE SET data = excluded.data"),
        trajectory(d,
                   "INSERT INTO trajectory(session, number, data) SELECT ?1, coalesce(max(number), 0) + 1, "
                   "?2 FROM trajectory WHERE session = ?1") {}

  Statement run, session, place, calibration, keyframe, cloud, features, images, camera;
  Statement copy_features, copy_images, copy_covariance;
  Statement drop_keyframe, drop_cloud, drop_features, drop_images, drop_edges_from, drop_edges_to;
  Statement clear_edges, drop_pair, edge, clear_landmarks, drop_landmark, landmark, trajectory;
};

void MapStore::Delete::operator()(Statements* statements) const {
  delete statements;
}

MapStore::MapStore(const std::filesystem::path& file, const char* vfs)
    : database_(open_for_writing(file, vfs)), statements_(new Statements(database_)) {}

void MapStore::copy_into(const std::filesystem::path& empty) {
  Statement(database_, "VACUUM INTO ?")(std::filesystem::canonical(empty).string()).run();
}

std::int64_t MapStore::add_run(const StoredRun& run) {
  statements_->run(run.version, run.configuration).run();
  return database_.last_row();
}

bool MapStore::has_run(std::int64_t id) {
  Statement run(database_, "SELECT 1 FROM run WHERE id = ?");
  return run(id).step();
}

bool MapStore::has_session(std::int64_t id) {
  Statement session(database_, "SELECT 1 FROM session WHERE id = ?");
  return session(id).step();
}

std::int64_t MapStore::add_session(std::int64_t run, const StoredSession& session) {
  statements_->session(run, session.mapper, session.sender, session.frame).run();
  return database_.last_row();
}

void MapStore::place_session(const StoredSession& session) {
  const auto state = static_cast<std::int64_t>(session.state);
  Statement& place = statements_->place;
  if (session.T_map_session) {
    const Blob pose = encode_pose(*session.T_map_session);
    place(state, pose, session.evidence, session.id).run();
  } else {
    place(state, nullptr, session.evidence, session.id).run();
  }
  if (database_.changes() == 0) database_.fail("there is no session " + std::to_string(session.id));
}

void MapStore::put_calibration(const StoredCalibration& calibration) {
  const Blob data = encode_bytes(calibration.bytes);
  statements_->calibration(calibration.sensor, calibration.form, data).run();
}

void MapStore::write(std::int64_t session, const SessionChanges& changes) {
  // What goes, goes first: its edges with it, and none of those that come.
  for (const auto& [id, change] : changes.keyframes())
    if (change.dropped) drop_keyframe(session, id);
  for (const auto& [id, change] : changes.keyframes()) write_keyframe(session, id, change);
  write_edges(session, changes);
  write_landmarks(session, changes);
  if (changes.trajectory().empty()) return;
  const Blob data = encode_trajectory(changes.trajectory());
  statements_->trajectory(session, data).run();
}

void MapStore::copy_keyframe(std::int64_t from_session, std::int64_t to_session, std::int32_t id) {
  const std::int64_t keyframe = id;
  for (Statement* statement :
       {&statements_->copy_features, &statements_->copy_images, &statements_->copy_covariance})
    (*statement)(from_session, to_session, keyframe).run();
}

void MapStore::drop_keyframe(std::int64_t session, std::int32_t id) {
  const std::int64_t keyframe = id;
  for (Statement* statement :
       {&statements_->drop_cloud, &statements_->drop_features, &statements_->drop_images,
        &statements_->drop_edges_from, &statements_->drop_edges_to, &statements_->drop_keyframe})
    (*statement)(session, keyframe).run();
}

void MapStore::write_keyframe(std::int64_t session, std::int32_t id, const KeyframeChange& change) {
  const std::int64_t keyframe = id;
  if (change.T_map_camera) {
    const Blob pose = encode_pose(*change.T_map_camera);
    const std::int64_t utime = change.utime.value_or(0);
    if (change.covariance) {
      const Blob covariance = encode_covariance(*change.covariance);
      statements_->keyframe(session, keyframe, utime, pose, covariance).run();
    } else {
      statements_->keyframe(session, keyframe, utime, pose, nullptr).run();
    }
  }
  if (change.cloud) {
    const Blob cloud = encode_cloud(*change.cloud);
    statements_->cloud(session, keyframe, static_cast<std::int64_t>(change.cloud->size()), cloud).run();
  }
  if (change.features) {
    const Blob features = encode_features(*change.features);
    statements_->features(session, keyframe, features).run();
  }
  if (change.images) write_images(session, keyframe, *change.images);
}

/// With their calibration, which the file has once.
void MapStore::write_images(std::int64_t session, std::int64_t keyframe, const StoredImages& images) {
  const Blob data = encode_images(images);
  const std::optional<StoredCalibration> known = calibration_of(images);
  const StoredCalibration by = known.value_or(StoredCalibration());
  const Blob told = encode_bytes(by.bytes);
  if (known) statements_->camera(by.sensor, by.form, told).run();
  statements_->images(session, keyframe, data, by.sensor, by.form, told).run();
}

std::optional<StoredCalibration> MapStore::calibration_of(const StoredImages& images) {
  if (images.calibration) return *images.calibration;
  Statement row(database_, std::string("SELECT sensor, form, data FROM calibration WHERE ") + is_of_sensor);
  if (!row(images.frame.sensor).step()) return std::nullopt;
  return StoredCalibration{row.text(0), row.text(1), decode_bytes(row.blob(2))};
}

void MapStore::write_edges(std::int64_t session, const SessionChanges& changes) {
  if (changes.edges_cleared()) statements_->clear_edges(session).run();
  for (const auto& [pair, edges] : changes.edges()) {
    const std::int64_t from = pair.first, to = pair.second;
    statements_->drop_pair(session, from, to).run();
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const Blob data = encode_edge(edges[i]);
      statements_->edge(session, from, to, static_cast<std::int64_t>(i), data).run();
    }
  }
}

void MapStore::write_landmarks(std::int64_t session, const SessionChanges& changes) {
  if (changes.landmarks_cleared()) statements_->clear_landmarks(session).run();
  for (const auto& [id, landmark] : changes.landmarks()) {
    if (!landmark) {
      statements_->drop_landmark(session, id).run();
      continue;
    }
    const Blob data = encode_landmark(*landmark);
    statements_->landmark(session, id, data).run();
  }
}

}  // namespace lcmslam

#include <lcmslam/map_store/file/store_schema.hpp>

#include <iterator>

namespace lcmslam {
namespace {

// In the file's header, so that nobody takes another program's database for a map: "LSLM".
constexpr std::int64_t application = 0x4C534C4D;

const char* const migrations[] = {
    // 1
    R"(CREATE TABLE run(
         id INTEGER PRIMARY KEY, version TEXT NOT NULL, configuration TEXT NOT NULL);
       CREATE TABLE session(
         id INTEGER PRIMARY KEY, run INTEGER NOT NULL REFERENCES run(id), mapper TEXT NOT NULL,
         sender INTEGER NOT NULL, frame TEXT NOT NULL);
       CREATE TABLE calibration(
         sensor TEXT PRIMARY KEY, form TEXT NOT NULL, data BLOB NOT NULL);
       CREATE TABLE keyframe(
         session INTEGER NOT NULL REFERENCES session(id), id INTEGER NOT NULL, utime INTEGER NOT NULL,
         pose BLOB NOT NULL, covariance BLOB, PRIMARY KEY(session, id)) WITHOUT ROWID;
       CREATE TABLE cloud(
         session INTEGER NOT NULL, keyframe INTEGER NOT NULL, points INTEGER NOT NULL, data BLOB NOT NULL,
         PRIMARY KEY(session, keyframe), FOREIGN KEY(session, keyframe) REFERENCES keyframe(session, id));
       CREATE TABLE features(
         session INTEGER NOT NULL, keyframe INTEGER NOT NULL, data BLOB NOT NULL,
         PRIMARY KEY(session, keyframe), FOREIGN KEY(session, keyframe) REFERENCES keyframe(session, id));
       CREATE TABLE edge(
         session INTEGER NOT NULL REFERENCES session(id), from_keyframe INTEGER NOT NULL,
         to_keyframe INTEGER NOT NULL, number INTEGER NOT NULL, data BLOB NOT NULL,
         PRIMARY KEY(session, from_keyframe, to_keyframe, number)) WITHOUT ROWID;
       CREATE TABLE landmark(
         session INTEGER NOT NULL REFERENCES session(id), id INTEGER NOT NULL, data BLOB NOT NULL,
         PRIMARY KEY(session, id)) WITHOUT ROWID;
       CREATE TABLE trajectory(
         session INTEGER NOT NULL REFERENCES session(id), number INTEGER NOT NULL, data BLOB NOT NULL,
         PRIMARY KEY(session, number)) WITHOUT ROWID;)",
    // 2: where a session lies in the map; edges are found from both ends
    R"(ALTER TABLE session ADD COLUMN state INTEGER NOT NULL DEFAULT 0;
       ALTER TABLE session ADD COLUMN T_map_session BLOB;
       ALTER TABLE session ADD COLUMN evidence TEXT NOT NULL DEFAULT '';
       CREATE INDEX edge_to ON edge(session, to_keyframe);)",
    // 3: of what derived maps are made
    R"(CREATE TABLE images(
         session INTEGER NOT NULL, keyframe INTEGER NOT NULL, data BLOB NOT NULL,
         PRIMARY KEY(session, keyframe), FOREIGN KEY(session, keyframe) REFERENCES keyframe(session, id));)",
    // 4: by which calibration images were taken. Those that are there already have camera 0: the one that had
    // been told of their sensor when the table was made. NULL: nobody knows.
    R"(CREATE TABLE camera(
         id INTEGER PRIMARY KEY, sensor TEXT NOT NULL, form TEXT NOT NULL, data BLOB NOT NULL,
         is_first INTEGER NOT NULL);
       INSERT INTO camera(sensor, form, data, is_first)
         SELECT sensor, form, data, 1 FROM calibration ORDER BY rowid;
       ALTER TABLE images ADD COLUMN camera INTEGER DEFAULT 0;)",
};

std::int64_t pragma(Database& database, const std::string& name) {
  Statement statement(database, "PRAGMA " + name);
  return statement.step() ? statement.integer(0) : 0;
}

}  // namespace

const char* const is_of_sensor = "instr(sensor || ';', ? || ';') = 1 ORDER BY rowid DESC LIMIT 1";
const int newest_schema = static_cast<int>(std::size(migrations));

int schema_of(Database& database) {
  if (pragma(database, "schema_version") == 0 && pragma(database, "application_id") == 0) return 0;
  if (pragma(database, "application_id") != application)
    database.fail("is a database, but no map of lcmslam (application_id is not that of an .lcmslam file)");
  const std::int64_t version = pragma(database, "user_version");
  if (version < 1 || version > newest_schema)
    database.fail("has schema version " + std::to_string(version) + ", and this program knows 1 to " +
                  std::to_string(newest_schema) + ": a newer lcmslam wrote it");
  return static_cast<int>(version);
}

void migrate(Database& database) {
  Transaction transaction(database);
  const int version = schema_of(database);
  for (int next = version; next < newest_schema; ++next) database.execute(migrations[next]);
  if (version < newest_schema) {
    database.execute("PRAGMA application_id = " + std::to_string(application));
    database.execute("PRAGMA user_version = " + std::to_string(newest_schema));
  }
  transaction.commit();
}

}  // namespace lcmslam

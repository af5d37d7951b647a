#include <lcmslam/map_store/file/compact_map_file.hpp>

#include <optional>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/file/clear_beside.hpp>
#include <lcmslam/map_store/file/store_schema.hpp>

namespace lcmslam {

void compact_map_file(const std::filesystem::path& file) {
  Database database(file, Database::Access::write);
  // A map server that wrote on meanwhile would wait for minutes, so it is not disturbed at all.
  database.execute("PRAGMA locking_mode = EXCLUSIVE");
  schema_of(database);
  database.execute("BEGIN EXCLUSIVE; COMMIT");
  database.execute("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)");
}

void copy_compacted(const std::filesystem::path& file, const FilePlace& copy) {
  std::optional<Database> database(std::in_place, file, Database::Access::read);
  schema_of(*database);
  database->execute("PRAGMA query_only = 0");  // it would hold for the copy, too
  write_atomically(copy, [&](const std::filesystem::path& part) {
    // By its own name: SQLite follows no links (Database), and `part` may be one.
    Statement(*database, "VACUUM INTO ?")(std::filesystem::canonical(part).string()).run();
    database.reset();  // the copy may take its place
    clear_beside(copy.path());
  });
}

}  // namespace lcmslam

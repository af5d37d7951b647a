#include <lcmslam/map_store/file/compact_map_file.hpp>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/file/clear_beside.hpp>
#include <lcmslam/map_store/file/store_schema.hpp>

namespace lcmslam {

void compact_map_file(const std::filesystem::path& file) {
  Database database(file, Database::Access::write);
  // A map server that wrote on meanwhile would wait for minutes, so it is not disturbed at all.
  database.execute("PRAGMA locking_mode = EXCLUSIVE");
  if (schema_of(database) == 0) return;  // it is empty; SQLite would make a database of nobody's out of it
  database.execute("BEGIN EXCLUSIVE; COMMIT");
  database.execute("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)");
}

void compact_into(const std::filesystem::path& file, const std::filesystem::path& empty) {
  Database database(file, Database::Access::read);
  if (schema_of(database) == 0) return;
  database.execute("PRAGMA query_only = 0");  // it would hold for the copy, too
  // By its own name: SQLite follows no links (Database), and `empty` may be one.
  Statement(database, "VACUUM INTO ?")(std::filesystem::canonical(empty).string()).run();
}

void copy_compacted(const std::filesystem::path& file, const FilePlace& copy) {
  write_atomically(copy, [&](const std::filesystem::path& part) {
    compact_into(file, part);
    clear_beside(copy.path());
  });
}

}  // namespace lcmslam

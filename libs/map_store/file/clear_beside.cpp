#include <lcmslam/map_store/file/clear_beside.hpp>

#include <fstream>

#include <lcmslam/map_store/file/sqlite.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

bool is_database(const fs::path& file) {
  const std::string magic = "SQLite format 3";
  std::string begin(magic.size(), ' ');
  return std::ifstream(file, std::ios::binary)
             .read(begin.data(), static_cast<std::streamsize>(begin.size())) &&
         begin == magic;
}

}  // namespace

void clear_beside(const fs::path& file) {
  if (is_database(file)) {
    Database database(file, Database::Access::write);
    database.execute("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; COMMIT");
    database.execute("PRAGMA journal_mode = DELETE");  // takes the log in, and away
  }
  for (const char* ending : {"-wal", "-shm"}) fs::remove(file.string() + ending);
}

}  // namespace lcmslam

#include <lcmslam/map_store/file/sqlite.hpp>

#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cctype>
#include <cstdlib>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

/// The folder's own path and the file's name: SQLite follows no links then (SQLITE_OPEN_NOFOLLOW).
std::string plain_path(const fs::path& file) {
  std::error_code missing;
  const fs::path folder = fs::canonical(fs::absolute(file).parent_path(), missing);
  if (missing) throw StoreError(file.string() + ": its folder: " + missing.message());
  return (folder / file.filename()).string();
}

/// As SQLite's URIs have names.
std::string percent_encoded(const std::string& path) {
  const char* digits = "0123456789ABCDEF";
  std::string text;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '/' || c == '.' || c == '-' || c == '_')
      text += c;
    else
      (text += '%') += {digits[byte >> 4], digits[byte & 15]};
  }
  return text;
}

/// A reader in WAL mode writes beside the file, and the last who closes it takes that away again. Where that
/// may not be (other people's folders, a disc) and nobody writes, the file is read as it stands.
bool may_write_beside(const std::string& path) {
  return access(path.c_str(), W_OK) == 0 && access(fs::path(path).parent_path().c_str(), W_OK) == 0;
}

std::string read_only_uri(const std::string& path) {
  std::error_code ignored;
  return "file:" + percent_encoded(path) + (fs::exists(path + "-wal", ignored) ? "" : "?immutable=1");
}

bool may_pass(int code) {
  switch (code & 0xff) {  // extended codes have more above
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_PROTOCOL:
    case SQLITE_IOERR:
    case SQLITE_FULL:
    case SQLITE_CANTOPEN:
    case SQLITE_NOMEM:
      return true;
    default:
      return false;
  }
}

}  // namespace

void Database::Close::operator()(sqlite3* handle) const {
  sqlite3_close_v2(handle);
}

Database::Database(const fs::path& file, Access mode, const char* vfs, std::chrono::milliseconds patience)
    : file_(file) {
  const std::string path = plain_path(file);
  std::error_code ignored;
  if (mode != Access::create && !fs::exists(fs::symlink_status(path, ignored))) fail("there is no such file");
  if (fs::is_symlink(fs::symlink_status(path, ignored))) fail("is a symbolic link, which is not followed");
  const bool only_read = mode == Access::read && !may_write_beside(path);
  const int flags = only_read                ? SQLITE_OPEN_READONLY | SQLITE_OPEN_URI
                    : mode == Access::create ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE
                                             : SQLITE_OPEN_READWRITE;
  sqlite3* handle = nullptr;
  const int code = sqlite3_open_v2((only_read ? read_only_uri(path) : path).c_str(), &handle,
                                   flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_NOFOLLOW, vfs);
  handle_.reset(handle);
  if (code != SQLITE_OK) fail(code, handle != nullptr ? sqlite3_errmsg(handle) : sqlite3_errstr(code));
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, static_cast<int>(patience.count()));
  if (mode == Access::read) execute("PRAGMA query_only = 1");
  // SQLite opens such files all the same, and speaks of a "disk I/O error" later.
  if (mode != Access::read && sqlite3_db_readonly(handle, "main") == 1)
    fail("cannot be written: the file or its disk is read-only");
}

void Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code, sqlite3_errmsg(handle()));
}

std::int64_t Database::changes() const {
  return sqlite3_changes64(handle());
}

std::int64_t Database::last_row() const {
  return sqlite3_last_insert_rowid(handle());
}

bool Database::has_moved() const {
  int moved = 0;
  sqlite3_file_control(handle(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  return moved != 0;
}

Database::Look Database::look_outside() const {
  struct stat now {};
  if (stat(file_.c_str(), &now) != 0) return {};
  return {now.st_size, now.st_mtim.tv_sec, now.st_mtim.tv_nsec};
}

sqlite3_file* Database::own_file() const {
  sqlite3_file* file = nullptr;
  sqlite3_file_control(handle(), "main", SQLITE_FCNTL_FILE_POINTER, &file);
  return file != nullptr && file->pMethods != nullptr ? file : nullptr;
}

/// Through SQLite's own handle: who opens and closes the file beside it takes its locks away.
std::vector<std::uint8_t> Database::first_bytes() const {
  constexpr int page = 4096;
  std::vector<std::uint8_t> bytes(page);
  if (sqlite3_file* file = own_file()) file->pMethods->xRead(file, bytes.data(), page, 0);
  return bytes;
}

/// By SQLite's index of its log (sqlite.org/walformat.html, nBackfill).
std::uint32_t Database::pages_taken_in() const {
  constexpr int index_size = 32768, place = 96;  // bytes
  sqlite3_file* file = own_file();
  void volatile* index = nullptr;
  if (file == nullptr || file->pMethods->iVersion < 2 ||
      file->pMethods->xShmMap(file, 0, index_size, 0, &index) != SQLITE_OK || index == nullptr)
    return 0;
  return static_cast<std::uint32_t volatile*>(index)[place / sizeof(std::uint32_t)];
}

/// As before where it cannot be told, since the file is another one; nothing while somebody holds it.
std::optional<std::int64_t> Database::version_of_others() const {
  std::int64_t version = noted_.version;
  const auto take = [](void* to, int, char** values, char**) {
    *static_cast<std::int64_t*>(to) = std::atoll(values[0]);
    return 0;
  };
  const int code = sqlite3_exec(handle(), "PRAGMA data_version", take, &version, nullptr) & 0xff;
  if (code == SQLITE_BUSY || code == SQLITE_LOCKED) return std::nullopt;
  return version;
}

void Database::note_written() {
  Look now = look_outside();
  now.begin = first_bytes();
  now.version = version_of_others().value_or(noted_.version);
  now.taken_in = pages_taken_in();
  noted_ = std::move(now);
}

bool Database::was_overwritten() {
  const Look now = look_outside();
  const bool is_touched =
      now.size != noted_.size || now.seconds != noted_.seconds || now.nanoseconds != noted_.nanoseconds;
  if (!is_touched || has_moved()) return false;
  const auto version = version_of_others();
  if (!version) return false;  // asked again
  const bool is_another = now.size != noted_.size || first_bytes() != noted_.begin;
  if (is_another && *version == noted_.version && pages_taken_in() == noted_.taken_in) return true;
  note_written();
  return false;
}

void Database::leave_file() {
  sqlite3_db_config(handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  for (const char* ending : {"-wal", "-shm"}) {
    std::error_code ignored;
    fs::remove(file_.string() + ending, ignored);
  }
}

void Database::fail(const std::string& why) const {
  const bool is_other = why == sqlite3_errstr(SQLITE_NOTADB);
  throw StoreError(file_.string() + ": " + why + (is_other ? ", so no map file (.lcmslam)" : ""));
}

void Database::fail(int code, const std::string& why) const {
  if (may_pass(code)) throw PassingStoreError(file_.string() + ": " + why);
  fail(why);
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Statement::Statement(Database& database, const std::string& sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  const int code =
      sqlite3_prepare_v3(database.handle(), sql.c_str(), -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) database.fail(code, sqlite3_errmsg(database.handle()));
  statement_.reset(statement);
}

void Statement::reset() {
  sqlite3_reset(statement_.get());  // tells the error of the last step again
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) database_.fail(code, sqlite3_errmsg(database_.handle()));
}

void Statement::bind(int index, std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), index, value));
}

void Statement::bind(int index, const std::string& value) {
  check(sqlite3_bind_text64(statement_.get(), index, value.data(), value.size(), SQLITE_TRANSIENT,
                            SQLITE_UTF8));
}

void Statement::bind(int index, const std::vector<std::uint8_t>& value) {
  check(sqlite3_bind_blob64(statement_.get(), index, value.data(), value.size(), SQLITE_STATIC));
}

void Statement::bind(int index, std::nullptr_t) {
  check(sqlite3_bind_null(statement_.get(), index));
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  const std::string error = code == SQLITE_DONE ? "" : sqlite3_errmsg(database_.handle());
  reset();
  if (!error.empty()) database_.fail(code, error);
  return false;
}

void Statement::run() {
  while (step()) {
  }
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string Statement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return text != nullptr ? std::string(text, text + size) : "";
}

std::vector<std::uint8_t> Statement::blob(int column) const {
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return bytes != nullptr ? std::vector<std::uint8_t>(bytes, bytes + size) : std::vector<std::uint8_t>();
}

bool Statement::is_null(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

Transaction::Transaction(Database& database, const char* kind) : database_(database) {
  database_.execute(std::string("BEGIN ") + kind);
}

Transaction::~Transaction() {
  // After some errors SQLite has rolled back by itself.
  if (open_ && sqlite3_get_autocommit(database_.handle()) == 0)
    sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace lcmslam

#pragma once
// SQLite as the map file needs it: a connection and its statements, which close themselves, and errors that
// name the file.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

struct sqlite3;
struct sqlite3_file;
struct sqlite3_stmt;

namespace lcmslam {

/// A map file that cannot be opened, read or written: names the file and the reason.
class StoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One that may pass by itself: somebody else holds the file, the disk is full or fails.
class PassingStoreError : public StoreError {
 public:
  using StoreError::StoreError;
};

class Database {
 public:
  enum class Access { read, write, create };  ///< create: write, and make what is not there

  /// Symbolic links in the folder's path are followed, the file itself must be none. `vfs`: SQLite's name of
  /// another file system (tests), nullptr for the usual one. `patience`: so long it waits for who holds the
  /// file. Throws StoreError.
  Database(const std::filesystem::path& file, Access mode, const char* vfs = nullptr,
           std::chrono::milliseconds patience = usual_patience);
  static constexpr std::chrono::milliseconds usual_patience{2000};

  /// One or more statements without parameters. Throws StoreError.
  void execute(const std::string& sql);
  /// Rows that the last statement changed, added or removed.
  std::int64_t changes() const;
  std::int64_t last_row() const;
  /// Whether the file that is open is not the one of that name any more: removed, or another is in its place.
  bool has_moved() const;
  /// Whether somebody has written another file over this one, byte by byte, since the last note_written().
  /// What other connections commit, or take into it of SQLite's log, is none of that.
  bool was_overwritten();
  /// What is in the file now is SQLite's. After opening and after each commit.
  void note_written();
  /// When it is closed nothing of SQLite's log goes into the file, and the log goes.
  void leave_file();
  /// `why`, with the file's name in front.
  [[noreturn]] void fail(const std::string& why) const;
  /// The same for what SQLite has answered, by its code.
  [[noreturn]] void fail(int code, const std::string& why) const;

  sqlite3* handle() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  /// As the file is seen from outside.
  struct Look {
    std::int64_t size = 0, seconds = 0, nanoseconds = 0;  // of its last change
    std::vector<std::uint8_t> begin{};                    // its first page
    std::int64_t version = 0;                             // rises when another connection commits
    std::uint32_t taken_in = 0;                           // pages of SQLite's log that are in it
  };
  Look look_outside() const;
  std::vector<std::uint8_t> first_bytes() const;
  std::uint32_t pages_taken_in() const;
  std::optional<std::int64_t> version_of_others() const;
  sqlite3_file* own_file() const;

  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Close> handle_;
  Look noted_;
};

/// A statement that is prepared once and run often.
class Statement {
 public:
  Statement(Database& database, const std::string& sql);

  /// Begins anew with these parameters: whole numbers, texts, blobs (those must live until the next call), or
  /// nullptr.
  template <class... Values>
  Statement& operator()(const Values&... values) {
    reset();
    int index = 0;
    (bind(++index, values), ...);
    return *this;
  }
  /// To the next row; false when there is none. Throws StoreError.
  bool step();
  /// To the end.
  void run();

  std::int64_t integer(int column) const;
  std::string text(int column) const;
  std::vector<std::uint8_t> blob(int column) const;
  bool is_null(int column) const;

 private:
  void reset();
  void bind(int index, std::int64_t value);
  void bind(int index, const std::string& value);
  void bind(int index, const std::vector<std::uint8_t>& value);
  void bind(int index, std::nullptr_t value);
  void check(int code) const;

  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// Undone unless it was committed.
class Transaction {
 public:
  /// IMMEDIATE: of several writers one waits here. DEFERRED: what is read is of one moment.
  explicit Transaction(Database& database, const char* kind = "IMMEDIATE");
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

}  // namespace lcmslam

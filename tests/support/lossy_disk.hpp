#pragma once
// A disk that can lose its power and be full, for SQLite: what was written since a file's last sync may be
// there afterwards or not, sector by sector. Reads and writes go to real files.

#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam::testing {

class LossyDisk {
 public:
  using Bytes = std::vector<char>;
  struct Change {
    std::int64_t offset = 0;
    Bytes bytes;               ///< written there
    bool is_truncate = false;  ///< to `offset`
  };
  struct File {
    Bytes synced;
    std::vector<Change> since;
    bool is_synced = false;  ///< before that not even its name is sure
    bool is_deleted = false;

    void sync() {
      for (const Change& change : since) {
        const auto at = static_cast<std::size_t>(change.offset);
        if (change.is_truncate)
          synced.resize(at);
        else
          synced.resize(std::max(synced.size(), at + change.bytes.size()));
        std::copy(change.bytes.begin(), change.bytes.end(), synced.begin() + change.offset);
      }
      since.clear();
      is_synced = true;
    }
  };
  using Files = std::map<std::string, File>;

  explicit LossyDisk(const std::string& name)
      : name_(name), below_(*sqlite3_vfs_find(nullptr)), vfs_(below_) {
    vfs_.zName = name_.c_str();
    vfs_.pAppData = this;
    vfs_.szOsFile = static_cast<int>(sizeof(OpenFile)) + below_.szOsFile;
    vfs_.xOpen = &LossyDisk::open;
    vfs_.xDelete = &LossyDisk::remove;
    sqlite3_vfs_register(&vfs_, 0);
  }
  ~LossyDisk() { sqlite3_vfs_unregister(&vfs_); }
  LossyDisk(const LossyDisk&) = delete;
  LossyDisk& operator=(const LossyDisk&) = delete;

  const char* vfs() const { return name_.c_str(); }
  bool full = false;
  std::function<void()> when_full;  ///< called by who writes then, at each write
  /// Writes, syncs, truncations and deletions so far.
  std::int64_t operations() const { return operations_; }
  /// Keeps the disk as it is before operation `number`, for lose_power().
  void remember_at(std::int64_t number) { moment_ = number; }

  /// What the folder holds after the power failed at the moment that was remembered, or else now: of all that
  /// was not synced a random part.
  void lose_power(const std::filesystem::path& folder, Random& random) const {
    constexpr std::size_t sector = 512;
    const double share = 0.5 * static_cast<double>(random.below(3));  // none, half, all of it
    const auto survives = [&] { return random.uniform(0, 1) < share; };
    for (const auto& [path, file] : remembered_ ? *remembered_ : files_) {
      Bytes bytes = file.synced;
      if (!file.is_synced && !survives()) continue;
      if (file.is_deleted && survives()) continue;
      for (const Change& change : file.since) {
        const auto at = static_cast<std::size_t>(change.offset);
        if (change.is_truncate && survives()) bytes.resize(std::min(bytes.size(), at));
        for (std::size_t begin = 0; begin < change.bytes.size(); begin += sector) {
          if (!survives()) continue;
          const std::size_t end = std::min(change.bytes.size(), begin + sector);
          bytes.resize(std::max(bytes.size(), at + end));
          std::copy(change.bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                    change.bytes.begin() + static_cast<std::ptrdiff_t>(end),
                    bytes.begin() + static_cast<std::ptrdiff_t>(at + begin));
        }
      }
      std::ofstream(folder / std::filesystem::path(path).filename(), std::ios::binary)
          .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
  }

 private:
  struct OpenFile {
    sqlite3_file base;
    LossyDisk* disk;
    const char* path;  // SQLite keeps it as long as the file is open; nullptr: temporary
    sqlite3_file* below() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  };
  static OpenFile* of(sqlite3_file* file) { return reinterpret_cast<OpenFile*>(file); }
  static sqlite3_file* below(sqlite3_file* file) { return of(file)->below(); }

  void count() {
    if (operations_++ == moment_) remembered_ = files_;
  }

  static int open(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags, int* out) {
    auto* disk = static_cast<LossyDisk*>(vfs->pAppData);
    file->pMethods = nullptr;
    of(file)->disk = disk;
    of(file)->path = path;
    const int code = disk->below_.xOpen(&disk->below_, path, below(file), flags, out);
    if (below(file)->pMethods != nullptr) file->pMethods = methods();
    if (code == SQLITE_OK && path != nullptr && disk->files_[path].is_deleted) disk->files_[path] = {};
    return code;
  }
  static int remove(sqlite3_vfs* vfs, const char* path, int sync_folder) {
    auto* disk = static_cast<LossyDisk*>(vfs->pAppData);
    disk->count();
    if (const auto file = disk->files_.find(path); file != disk->files_.end()) {
      file->second.is_deleted = true;
      if (sync_folder != 0) disk->files_.erase(file);
    }
    return disk->below_.xDelete(&disk->below_, path, sync_folder);
  }
  static int write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 offset) {
    LossyDisk* disk = of(file)->disk;
    disk->count();
    if (disk->full) {
      if (disk->when_full) disk->when_full();
      return SQLITE_FULL;
    }
    if (of(file)->path != nullptr) {
      const char* begin = static_cast<const char*>(bytes);
      disk->files_[of(file)->path].since.push_back({offset, Bytes(begin, begin + size), false});
    }
    return below(file)->pMethods->xWrite(below(file), bytes, size, offset);
  }
  static int truncate(sqlite3_file* file, sqlite3_int64 size) {
    LossyDisk* disk = of(file)->disk;
    disk->count();
    if (of(file)->path != nullptr) disk->files_[of(file)->path].since.push_back({size, {}, true});
    return below(file)->pMethods->xTruncate(below(file), size);
  }
  /// The real disk need not do it.
  static int sync(sqlite3_file* file, int) {
    LossyDisk* disk = of(file)->disk;
    disk->count();
    if (of(file)->path != nullptr) disk->files_[of(file)->path].sync();
    return SQLITE_OK;
  }

  /// Those of SQLite's own files but for the three above; version 2: no file is mapped.
  static const sqlite3_io_methods* methods() {
    static const sqlite3_io_methods table = [] {
      sqlite3_io_methods m{};
      m.iVersion = 2;
      m.xClose = [](sqlite3_file* f) { return below(f)->pMethods->xClose(below(f)); };
      m.xRead = [](sqlite3_file* f, void* to, int size, sqlite3_int64 offset) {
        return below(f)->pMethods->xRead(below(f), to, size, offset);
      };
      m.xWrite = &LossyDisk::write;
      m.xTruncate = &LossyDisk::truncate;
      m.xSync = &LossyDisk::sync;
      m.xFileSize = [](sqlite3_file* f, sqlite3_int64* s) {
        return below(f)->pMethods->xFileSize(below(f), s);
      };
      m.xLock = [](sqlite3_file* f, int l) { return below(f)->pMethods->xLock(below(f), l); };
      m.xUnlock = [](sqlite3_file* f, int l) { return below(f)->pMethods->xUnlock(below(f), l); };
      m.xCheckReservedLock = [](sqlite3_file* f, int* r) {
        return below(f)->pMethods->xCheckReservedLock(below(f), r);
      };
      m.xFileControl = [](sqlite3_file* f, int op, void* argument) {
        return below(f)->pMethods->xFileControl(below(f), op, argument);
      };
      m.xSectorSize = [](sqlite3_file* f) { return below(f)->pMethods->xSectorSize(below(f)); };
      m.xDeviceCharacteristics = [](sqlite3_file* f) {
        return below(f)->pMethods->xDeviceCharacteristics(below(f));
      };
      m.xShmMap = [](sqlite3_file* f, int page, int size, int extend, void volatile** memory) {
        return below(f)->pMethods->xShmMap(below(f), page, size, extend, memory);
      };
      m.xShmLock = [](sqlite3_file* f, int offset, int n, int flags) {
        return below(f)->pMethods->xShmLock(below(f), offset, n, flags);
      };
      m.xShmBarrier = [](sqlite3_file* f) { below(f)->pMethods->xShmBarrier(below(f)); };
      m.xShmUnmap = [](sqlite3_file* f, int remove_it) {
        return below(f)->pMethods->xShmUnmap(below(f), remove_it);
      };
      return m;
    }();
    return &table;
  }

  std::string name_;
  sqlite3_vfs below_;
  sqlite3_vfs vfs_;
  Files files_;
  std::int64_t operations_ = 0, moment_ = -1;
  std::optional<Files> remembered_;
};

}  // namespace lcmslam::testing

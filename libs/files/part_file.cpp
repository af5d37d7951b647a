#include <lcmslam/files/part_file.hpp>

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail() {
  throw std::runtime_error(std::strerror(errno));
}

std::string file_name(const fs::path& file) {
  if (file.filename().empty())
    throw std::runtime_error("cannot save " + file.string() + ": the file name is missing");
  return file.filename();
}

HeldFolder folder_of(const fs::path& file) {
  try {
    return HeldFolder(file.has_parent_path() ? file.parent_path() : fs::path("."));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("cannot save " + file.string() + ": the " + error.what());
  }
}

/// Several threads may write files of one name.
std::string part_name(const std::string& name) {
  static std::atomic<int> made{0};
  return name + ".part" + std::to_string(getpid()) + "-" + std::to_string(made++);
}

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// Whether part_name() makes such names: `split` makes run.lcmlog.part00, and that is the user's.
bool is_part_of(const std::string& candidate, const std::string& name) {
  const std::string begin = name + ".part";
  if (candidate.compare(0, begin.size(), begin) != 0) return false;
  const std::string rest = candidate.substr(begin.size());
  const std::size_t dash = rest.find('-');
  return dash != std::string::npos && is_number(rest.substr(0, dash)) && is_number(rest.substr(dash + 1));
}

/// Taking the name would replace a link, or a device such as /dev/full, by a file.
void check_target(const FilePlace& file) {
  struct stat target {};
  if (fstatat(file.folder.descriptor(), file.name.c_str(), &target, AT_SYMLINK_NOFOLLOW) != 0) return;
  if (S_ISDIR(target.st_mode)) throw std::runtime_error("is a folder");
  if (S_ISLNK(target.st_mode)) throw std::runtime_error("is a symbolic link, which is not followed");
  if (!S_ISREG(target.st_mode)) throw std::runtime_error("is not a regular file");
}

/// The names in a folder; none when it may not be read.
std::vector<std::string> names_in(const HeldFolder& folder) {
  std::vector<std::string> names;
  const int copy = openat(folder.descriptor(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR* listing = copy < 0 ? nullptr : fdopendir(copy);
  if (listing == nullptr) {
    if (copy >= 0) close(copy);
    return names;
  }
  while (const dirent* entry = readdir(listing)) names.emplace_back(entry->d_name);
  closedir(listing);
  return names;
}

}  // namespace

FilePlace::FilePlace(const fs::path& file) : folder(folder_of(file)), name(file_name(file)) {}

PartFile::PartFile(const FilePlace& place) : place_(place), part_(part_name(place.name)) {
  check_target(place);
  remove_stale();
  descriptor_ = openat(place_.folder.descriptor(), part_.c_str(),
                       O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail();
  flock(descriptor_, LOCK_EX | LOCK_NB);  // a file system without locks: then nobody removes it either
}

PartFile::~PartFile() {
  if (!named_) unlinkat(place_.folder.descriptor(), part_.c_str(), 0);
  close(descriptor_);
}

fs::path PartFile::path() const {
  return "/proc/self/fd/" + std::to_string(descriptor_);
}

void PartFile::flush() {
  if (fsync(descriptor_) != 0 && errno != EINVAL) fail();  // EINVAL: a file system without fsync
}

void PartFile::take_name() {
  const int folder = place_.folder.descriptor();
  if (renameat(folder, part_.c_str(), folder, place_.name.c_str()) != 0) fail();
  named_ = true;
}

void PartFile::remove_stale() const {
  for (const std::string& name : names_in(place_.folder)) {
    if (!is_part_of(name, place_.name)) continue;
    const int other =
        openat(place_.folder.descriptor(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (other < 0) continue;
    if (flock(other, LOCK_EX | LOCK_NB) == 0) unlinkat(place_.folder.descriptor(), name.c_str(), 0);
    close(other);
  }
}

}  // namespace lcmslam

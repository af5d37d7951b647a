#include <lcmslam/map_store/atomic_file.hpp>

#include <fcntl.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& reason) {
  throw std::runtime_error("cannot save " + file.string() + ": " + reason);
}

std::string system_reason() {
  return std::strerror(errno);
}

/// Waits until the file's (or folder's) content is on the disk.
bool flush_to_disk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool flushed = fsync(descriptor) == 0 || errno == EINVAL;  // EINVAL: a file system without fsync
  const int error = errno;
  close(descriptor);
  errno = error;
  return flushed;
}

void check_target(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  if (file.filename().empty()) fail(file, "the file name is missing");
  const fs::file_status target = fs::status(file, error);
  if (fs::is_directory(target)) fail(file, "is a folder");
  // Renaming would replace a device such as /dev/full by a file.
  if (fs::exists(target) && !fs::is_regular_file(target)) fail(file, "is not a regular file");
  if (!fs::is_directory(folder, error)) fail(file, "the folder " + folder.string() + " does not exist");
}

}  // namespace

void write_atomically(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  check_target(file, folder);
  const fs::path temporary =
      folder / ("." + file.filename().string() + ".partial" + std::to_string(getpid()));
  // Made here so that a folder that cannot be written to gives the system's reason.
  const int made = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (made < 0) fail(file, system_reason());
  close(made);

  const auto give_up = [&](const std::string& reason) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    fail(file, reason);
  };
  try {
    write(temporary);
  } catch (const std::exception& error) {
    give_up(error.what());
  }
  if (!flush_to_disk(temporary)) give_up(system_reason());
  if (std::rename(temporary.c_str(), file.c_str()) != 0) give_up(system_reason());
  flush_to_disk(folder);  // the new name itself; the content is safe already
}

void write_atomically(const fs::path& file, const std::string& bytes) {
  write_atomically(file, [&](const fs::path& temporary) {
    const int descriptor = open(temporary.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
    if (descriptor < 0) throw std::runtime_error(system_reason());
    std::string problem;
    for (std::size_t done = 0; done < bytes.size() && problem.empty();) {
      const ssize_t written = ::write(descriptor, bytes.data() + done, bytes.size() - done);
      if (written >= 0)
        done += static_cast<std::size_t>(written);
      else if (errno != EINTR)
        problem = system_reason();
    }
    if (close(descriptor) != 0 && problem.empty()) problem = system_reason();
    if (!problem.empty()) throw std::runtime_error(problem);
  });
}

}  // namespace lcmslam

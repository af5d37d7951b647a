#include "tools/study/faults/small_disk.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <cerrno>
#include <system_error>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/map_store/file/sqlite.hpp>
#include "tools/launch/graph.hpp"

namespace lcmslam {

bool own_mounts() {
  share_folder();  // programs and files are found by the name that this one has before
  program_folder();
  return unshare(CLONE_NEWNS) == 0 && mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
}

SmallDisk::SmallDisk(std::filesystem::path folder, int megabytes) : folder_(std::move(folder)) {
  const std::string size = "size=" + std::to_string(megabytes) + "m";
  std::filesystem::create_directories(folder_);
  if (mount("tmpfs", folder_.c_str(), "tmpfs", MS_NOSUID | MS_NODEV, size.c_str()) != 0)
    throw std::system_error(errno, std::generic_category(), "no small disk at " + folder_.string());
}

// Who still holds a file there keeps it until then.
SmallDisk::~SmallDisk() {
  umount2(folder_.c_str(), MNT_DETACH);
}

Ballast::Ballast(std::filesystem::path folder, const std::filesystem::path& map)
    : file_(std::move(folder) / "ballast") {
  if (std::filesystem::exists(map))
    Database(map, Database::Access::write).execute("PRAGMA wal_checkpoint(TRUNCATE)");
  fill();
}

Ballast::~Ballast() {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

/// Nearly all is taken without being written: that would hold up the run for a third of a second.
void Ballast::fill() {
  const int file = open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0) return;
  struct statvfs room {};
  const off_t size = lseek(file, 0, SEEK_END);
  const bool has_room = fstatvfs(file, &room) == 0 && room.f_bavail > 0;
  if (has_room) (void)fallocate(file, 0, size, static_cast<off_t>(room.f_bavail * room.f_frsize));
  const std::string rest(4096, 'x');
  while (write(file, rest.data(), rest.size()) > 0) continue;
  close(file);
}

}  // namespace lcmslam

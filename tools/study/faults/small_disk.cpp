#include "tools/study/faults/small_disk.hpp"

#include <sched.h>
#include <sys/mount.h>
#include <cerrno>
#include <fstream>
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

void Ballast::fill() {
  const std::string megabyte(1 << 20, 'x');
  std::ofstream file(file_, std::ios::binary | std::ios::app);
  while (file) file << megabyte << std::flush;  // the last one as far as it fits
}

}  // namespace lcmslam

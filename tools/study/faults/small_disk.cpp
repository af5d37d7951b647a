#include "tools/study/faults/small_disk.hpp"

#include <sched.h>
#include <sys/mount.h>
#include <cerrno>
#include <system_error>

#include <lcmslam/configuration/share.hpp>

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

}  // namespace lcmslam

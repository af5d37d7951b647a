#include <lcmslam/configuration/share.hpp>

#include <cstdlib>

#include <lcmslam/configuration/config.hpp>

namespace lcmslam {

namespace fs = std::filesystem;

fs::path share_folder() {
  if (const char* given = std::getenv("LCMSLAM_SHARE"); given != nullptr && *given != '\0') return given;
  // Asked once: in a mount namespace that is entered later, the kernel names the file from its mount's root.
  static const fs::path program = fs::read_symlink("/proc/self/exe");
  return program.parent_path().parent_path() / "share" / "lcmslam";
}

fs::path share_path(const fs::path& name) {
  const fs::path path = share_folder() / name;
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  if (error)
    throw ConfigError(path.string() + ": is not there; LCMSLAM_SHARE names the folder that holds lcmslam's " +
                      name.begin()->string() + ", say /usr/share/lcmslam");
  return real;
}

}  // namespace lcmslam

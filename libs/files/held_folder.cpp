#include <lcmslam/files/held_folder.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_name = 100;

[[noreturn]] void fail(const fs::path& folder, const std::string& reason) {
  throw std::runtime_error("folder " + folder.string() + ": " + reason);
}

bool is_allowed(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
         c == '_';
}

/// The name as it may stand in a message: control characters would forge lines of it.
std::string shown(const std::string& name) {
  std::string text = name.substr(0, longest_name);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c >= 0 && c < ' '; }, '?');
  return "'" + text + "'";
}

std::vector<std::string> parts_of(const std::string& name) {
  std::vector<std::string> parts;
  std::istringstream text(name + "/");
  for (std::string part; std::getline(text, part, '/');) parts.push_back(part);
  try {
    for (const std::string& part : parts) check_name(part);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("folder " + shown(name) + ": " + error.what());
  }
  return parts;
}

}  // namespace

void check_name(const std::string& name) {
  const bool good = !name.empty() && name.size() <= longest_name && name.front() != '.' &&
                    std::all_of(name.begin(), name.end(), is_allowed);
  if (!good)
    throw std::runtime_error("the name " + shown(name) + " must be 1 to " + std::to_string(longest_name) +
                             " letters, digits, dots, dashes and underscores, with no dot in front");
}

HeldFolder::HeldFolder(fs::path path, int descriptor)
    : path_(std::move(path)), descriptor_(new int(descriptor), [](const int* held) {
        close(*held);
        delete held;
      }) {}

HeldFolder::HeldFolder(const fs::path& folder)
    : HeldFolder(folder, open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor() < 0) fail(folder, errno == ENOENT ? "does not exist" : std::strerror(errno));
}

HeldFolder HeldFolder::below(const std::string& name) const {
  HeldFolder folder = *this;
  for (const std::string& part : parts_of(name)) {
    const fs::path path = folder.path() / part;
    if (mkdirat(folder.descriptor(), part.c_str(), 0777) != 0 && errno != EEXIST)
      fail(path, std::strerror(errno));
    const int next =
        openat(folder.descriptor(), part.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (next < 0)
      fail(path, errno == ENOTDIR || errno == ELOOP ? "is no folder (symbolic links are not followed)"
                                                    : std::strerror(errno));
    folder = HeldFolder(path, next);
  }
  return folder;
}

}  // namespace lcmslam

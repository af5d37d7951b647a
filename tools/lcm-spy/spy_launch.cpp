#include "tools/lcm-spy/spy_launch.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <cstddef>
#include <sstream>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

fs::path find_file(const std::vector<fs::path>& folders, const std::string& name) {
  for (const fs::path& folder : folders)
    if (is_file(folder / name)) return folder / name;
  return {};
}

/// HOME/lib/libawt_xawt.so of HOME/bin/java comes with the packages that can draw.
bool has_windows(const fs::path& java) {
  std::error_code error;
  const fs::path real = fs::canonical(java, error);
  return !error && is_file(real.parent_path().parent_path() / "lib/libawt_xawt.so");
}

/// The path of a file, or with a NUL before it a name that is no file.
bool accepts(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return false;
  path.copy(address.sun_path, path.size());
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  const bool connected = connect(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0;
  close(fd);
  return connected;
}

}  // namespace

bool display_answers(const std::string& display) {
  const std::size_t colon = display.find(':');
  if (colon == std::string::npos || (colon > 0 && display.compare(0, colon, "unix") != 0)) return true;
  const std::string number = display.substr(colon + 1, display.find('.', colon) - colon - 1);
  const std::string path = "/tmp/.X11-unix/X" + number;
  return accepts(path) || accepts(std::string(1, '\0') + path);
}

SpyParts find_spy_parts(const std::string& search_path, const std::vector<fs::path>& libraries,
                        const fs::path& own, const std::string& display) {
  SpyParts parts;
  std::istringstream folders(search_path);
  for (std::string folder; parts.java.empty() && std::getline(folders, folder, ':');)
    if (const fs::path java = fs::path(folder) / "java"; is_file(java) && access(java.c_str(), X_OK) == 0)
      parts.java = java;
  parts.java_draws = !parts.java.empty() && has_windows(parts.java);
  parts.lcm_jar = find_file(libraries, "lcm.jar");
  parts.chart_jar = find_file(libraries, "jchart2d.jar");
  parts.types_jar = find_file({own}, "lcmslam_types.jar");
  parts.plugin_jar = find_file({own}, "lcmslam_spy.jar");
  parts.display = display;
  return parts;
}

std::string missing_part(const SpyParts& parts) {
  if (parts.java.empty())
    return "there is no Java; install it with: sudo apt-get install default-jre liblcm-java libjchart2d-java";
  if (parts.lcm_jar.empty()) return "there is no lcm.jar; install it with: sudo apt-get install liblcm-java";
  if (parts.chart_jar.empty())
    return "there is no jchart2d.jar; install it with: sudo apt-get install libjchart2d-java";
  if (parts.types_jar.empty() || parts.plugin_jar.empty())
    return std::string(parts.types_jar.empty() ? "lcmslam_types.jar" : "lcmslam_spy.jar") +
           " was not built, for want of a Java compiler; make it with: sudo apt-get install "
           "default-jdk-headless liblcm-java libjchart2d-java && cmake --preset release && ./lcmslam build";
  return {};
}

std::string spy_obstacle(const SpyParts& parts) {
  if (!parts.java.empty() && !parts.java_draws)
    return parts.java.string() +
           " is a Java without windows; install one with: sudo apt-get install default-jre";
  if (const std::string missing = missing_part(parts); !missing.empty()) return missing;
  if (parts.display.empty())
    return "there is no X display (DISPLAY is not set); start it on a desktop or through ssh -X, or use "
           "./lcmslam spy, which needs none";
  if (!display_answers(parts.display))
    return "no X server answers at DISPLAY=" + parts.display +
           "; set DISPLAY to one that runs, or use ./lcmslam spy, which needs none";
  return {};
}

std::vector<std::string> spy_arguments(const SpyParts& parts, const std::string& lcm_url,
                                       const std::vector<std::string>& more) {
  std::string class_path;
  for (const fs::path& jar : {parts.lcm_jar, parts.chart_jar, parts.types_jar, parts.plugin_jar})
    class_path += (class_path.empty() ? "" : ":") + jar.string();
  // Java's LCM knows no IPv6.
  std::vector<std::string> arguments = {parts.java,
                                        "-Djava.net.preferIPv4Stack=true",
                                        "-Xmx256m",
                                        "-cp",
                                        class_path,
                                        "lcm.spy.Spy",
                                        "--lcm-url=" + lcm_url};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace lcmslam

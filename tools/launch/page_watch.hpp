#pragma once
// Where the live page of a graph that was started is: the map server says it in its log, with the token if
// there is one, which must not go over the bus.

#include <cstdint>
#include <filesystem>
#include <string>

namespace lcmslam {

class PageWatch {
 public:
  /// Of what the log says from now on. It need not be there yet.
  explicit PageWatch(std::filesystem::path log);

  /// "the live page: http://..." or why there is none, when the log says so anew; else empty.
  std::string news();
  /// The last news.
  const std::string& last() const { return last_; }

 private:
  std::filesystem::path log_;
  std::uintmax_t read_ = 0;  // bytes
  std::string last_;
};

/// The map server's log below a run's folder.
std::filesystem::path map_server_log(const std::filesystem::path& folder);

/// Setting for a private bus: its loop-back interface is another one than the browser's.
inline constexpr const char* without_page = "map-server.page.serve=false";
/// That there is none, and what to do; the folder takes the map file.
std::string no_page_on_a_private_bus(const std::filesystem::path& folder);

}  // namespace lcmslam

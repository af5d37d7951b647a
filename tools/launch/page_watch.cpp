#include "tools/launch/page_watch.hpp"

#include <fstream>

namespace lcmslam {
namespace {

std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

/// What a line says of the page; empty: nothing.
std::string said_of_the_page(const std::string& line) {
  for (const char* begin : {"the live page: ", "there is no live page"})
    if (const std::size_t at = line.find(begin); at != std::string::npos) return line.substr(at);
  return {};
}

}  // namespace

PageWatch::PageWatch(std::filesystem::path log) : log_(std::move(log)), read_(size_of(log_)) {}

std::string PageWatch::news() {
  const std::uintmax_t size = size_of(log_);
  if (size == read_) return {};
  if (size < read_) read_ = 0;  // it began anew
  std::ifstream log(log_, std::ios::binary);
  log.seekg(static_cast<std::streamoff>(read_));
  std::string found;
  for (std::string line; std::getline(log, line) && !log.eof();) {  // half a line is read when it is whole
    read_ += line.size() + 1;
    if (std::string said = said_of_the_page(line); !said.empty()) found = std::move(said);
  }
  if (found.empty() || found == last_) return {};
  last_ = found;
  return found;
}

std::filesystem::path map_server_log(const std::filesystem::path& folder) {
  return folder / "logs" / "map-server.txt";
}

std::string no_page_on_a_private_bus(const std::filesystem::path& folder) {
  return "there is no live page: no browser reaches a private bus; afterwards  ./lcmslam map view " +
         (folder / "map.lcmslam").string();
}

}  // namespace lcmslam

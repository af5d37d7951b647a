// Any MAP_REQUEST: map-server answers each once, with what it wrote or with words; nothing is written but
// below the run's folder, through no link, and in no more folders than the settings allow.

#include <spdlog/spdlog.h>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <lcmslam/map_reply_t.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

void require(bool condition) {
  if (!condition) std::abort();
}

/// A run's folder with a link out of it and a file where a folder may be asked for, beside what is nobody's
/// business.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (fs::temp_directory_path() / "lcmslam-requests-XXXXXX").string();
    require(mkdtemp(pattern.data()) != nullptr);
    root_ = pattern;
    fs::create_directories(root_ / "other");
    empty_run();
  }
  ~Scratch() { fs::remove_all(root_); }

  fs::path run() const { return root_ / "run"; }
  void empty_run() const {
    fs::remove_all(run());
    fs::create_directories(run());
    fs::create_directory_symlink(root_ / "other", run() / "link");
    std::ofstream(run() / "file") << "kept";
  }
  bool rest_is_untouched() const {
    std::string kept;
    std::ifstream(run() / "file") >> kept;
    std::size_t entries = 0;
    for (const auto& entry : fs::directory_iterator(root_)) entries += entry.exists();
    return entries == 2 && fs::is_empty(root_ / "other") && kept == "kept" && fs::is_symlink(run() / "link");
  }
  std::size_t folders() const {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(run()))
      count += entry.is_directory() && !entry.is_symlink();
    return count;
  }

 private:
  fs::path root_;
};

/// One byte says which kind, the rest are requests a line: the argument, a blank, the formats; a question is
/// a line.
void ask(testing::TestBus& bus, std::int8_t kind, std::string line, std::int64_t id) {
  line.erase(std::remove(line.begin(), line.end(), '\0'), line.end());  // no string of LCM holds one
  map_request_t request{};
  request.request_id = id;
  request.kind = kind;
  const bool question = kind == map_request_t::QUERY;
  const std::size_t blank = question ? line.size() : std::min(line.find(' '), line.size());
  request.format = blank < line.size() ? line.substr(blank + 1) : "ply";
  request.argument = line.substr(0, blank);
  bus.deliver("MAP_REQUEST", request);
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  static const Scratch scratch;
  spdlog::set_level(spdlog::level::off);
  if (size == 0) return 0;
  scratch.empty_run();
  testing::TestBus bus;
  bus.add<MapServerNode>(ConfigNode::parse("{folder: " + scratch.run().string() +
                                           ", export_folders: 3, layers: {background: false}}"));
  std::istringstream lines(std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  std::int64_t asked = 0;
  for (std::string line; asked < 20 && std::getline(lines, line);)
    ask(bus, static_cast<std::int8_t>(data[0] % 4), line, ++asked);
  bus.work();
  const auto replies = bus.on<map_reply_t>("MAP_REPLY");
  require(static_cast<std::int64_t>(replies.size()) == asked);
  std::set<std::int64_t>
      answered;  // in any order: a wrong question is answered at once, a right one takes its time
  for (const map_reply_t& reply : replies) {
    require(reply.request_id >= 1 && reply.request_id <= asked && answered.insert(reply.request_id).second);
    require(reply.status == 0 || (!reply.message.empty() && reply.message.find('\n') == std::string::npos));
  }
  require(scratch.rest_is_untouched() && scratch.folders() <= 3);
  return 0;
}

// Any bytes from a browser, as HTTP and behind the handshake of each WebSocket: the server answers or hangs
// up, serves others on, and its files alone.

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <lcmslam/web/web_server.hpp>
#include "tests/support/web_client.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

void require(bool condition) {
  if (!condition) std::abort();
}

class Server {
 public:
  Server() {
    std::string pattern = (fs::temp_directory_path() / "lcmslam-web-XXXXXX").string();
    require(mkdtemp(pattern.data()) != nullptr);
    folder_ = pattern;
    std::ofstream(folder_ / "index.html") << "page";
    for (int i = 0; i < 50; ++i)
      board_.put({"points",
                  std::to_string(i),
                  "{}",
                  std::make_shared<const std::string>(200, 'x'),
                  Haste::bulk,
                  i,
                  {}});
    settings_.port = 0;
    settings_.token = "open-sesame";
    WebServer::Handlers handlers;
    handlers.command = [](std::uint64_t, const std::string& text, const WebServer::Reply& reply) {
      reply(text);
    };
    server_ = std::make_unique<WebServer>(settings_, folder_, board_, handlers);
  }
  ~Server() { fs::remove_all(folder_); }
  int port() const { return server_->port(); }

 private:
  fs::path folder_;
  WebSettings settings_;
  Board board_;
  std::unique_ptr<WebServer> server_;
};

/// Where the connections before are not all taken down yet, somebody is asked to come again.
bool serves_others(int port) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < until) {
    testing::WebClient other(port);
    if (other.get("/?token=open-sesame").find("page") != std::string::npos) return true;
  }
  return false;
}

void check(const std::uint8_t* data, std::size_t size) {
  static const Server server;
  if (size == 0) return;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  {
    testing::WebClient client(server.port());
    client.patience = 1;
    switch (data[0] % 4) {
      case 0: {
        client.send(bytes);
        const std::string answer = client.response();
        const bool knows = bytes.find("open-sesame") != std::string::npos;
        require(knows || answer.find("200 OK") == std::string::npos);
        break;
      }
      case 1:
      case 2:
        if (!client.open_socket(data[0] % 4 == 1 ? "/live?token=open-sesame" : "/command?token=open-sesame"))
          return;
        client.send(bytes);
        client.hear();
        break;
      default:
        if (!client.open_socket("/live?token=open-sesame")) return;
        client.say(bytes);
        client.hear();
    }
  }
  static int inputs = 0;
  if (++inputs % 100 == 0) require(serves_others(server.port()));
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lcmslam::check(data, size);
  return 0;
}

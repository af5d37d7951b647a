#pragma once
// Serves a page to browsers: its files over HTTP, a board over the WebSocket /live, commands over the
// WebSocket /command (docs/LIVE_PAGE.md). One thread; nothing that a browser does or leaves undone holds up
// whoever fills the board.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <lcmslam/web/board.hpp>
#include <lcmslam/web/web_settings.hpp>

namespace lcmslam {

struct WebCounts {
  std::int64_t clients = 0;  ///< browsers that watch now
  std::int64_t commands = 0;
  std::int64_t bytes = 0;  ///< that went out on /live
  // Refused so far:
  std::int64_t strangers = 0;  ///< wrong host, origin or token
  std::int64_t bad = 0;        ///< requests and messages that are none, or too large
  std::int64_t too_many = 0;   ///< beyond most_clients; also silent connections that made room for new ones
  std::int64_t let_go = 0;     ///< browsers that took nothing
  std::int64_t refused() const { return strangers + bad + too_many + let_go; }
};

class WebServer {
 public:
  using Reply = std::function<void(std::string)>;
  struct Handlers {
    /// A text of a browser on /command, in the server's thread. `reply` is called once, by any thread, then
    /// or later; when the browser is gone nothing happens.
    std::function<void(std::uint64_t who, const std::string& request, const Reply& reply)> command;
    /// Its socket closed.
    std::function<void(std::uint64_t who)> closed;
  };

  /// Serves from here on. The board must live longer. Throws std::runtime_error that names the address, the
  /// port and the setting to change, or the folder that has no page.
  WebServer(const WebSettings& settings, const std::filesystem::path& folder, const Board& board,
            Handlers handlers);
  /// Closes all sockets; no handler is called afterwards.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  int port() const;
  /// "http://127.0.0.1:8642/", with the token where one is asked for.
  std::string address() const;
  WebCounts counts() const;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace lcmslam

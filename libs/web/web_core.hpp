#pragma once
// What the connections of a server share. Internal: only this room's .cpp files see Beast.

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <list>
#include <set>
#include <thread>

#include <lcmslam/web/access.hpp>
#include <lcmslam/web/client_queue.hpp>
#include <lcmslam/web/static_files.hpp>
#include <lcmslam/web/web_server.hpp>

namespace lcmslam {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Socket = beast::websocket::stream<beast::tcp_stream>;
using Upgrade = http::request<http::string_body>;

/// A WebSocket that the server looks after.
class Connection {
 public:
  virtual ~Connection() = default;
  /// Some fifty times a second.
  virtual void tick(double now) = 0;
  virtual void close() = 0;
};

/// Who has connected and not yet said a whole request.
class Reading {
 public:
  virtual ~Reading() = default;
  virtual void give_way() = 0;
};

struct WebShared {
  WebShared(const WebSettings& web, const std::filesystem::path& folder, const Board& items,
            WebServer::Handlers functions)
      : settings(web),
        files(folder),
        access(web),
        board(items),
        handlers(std::move(functions)),
        patience(static_cast<std::int64_t>(1e3 * web.patience)) {}

  const WebSettings settings;
  const StaticFiles files;
  const Access access;
  const Board& board;
  const WebServer::Handlers handlers;
  const std::chrono::milliseconds patience;  // with whoever begins something and does not go on
  /// Of the server alone: what waits in it holds connections, and they hold this.
  std::weak_ptr<asio::io_context> io;

  // Of the server's thread.
  std::set<std::shared_ptr<Connection>> connections;
  int live = 0, command = 0, plain = 0;  // sockets of each kind
  std::list<Reading*> reading;           // who has waited longest first
  std::uint64_t last_client = 0;
  bool stopping = false;

  struct Counts {
    std::atomic<std::int64_t> clients{0}, commands{0}, bytes{0}, strangers{0}, bad{0}, too_many{0}, let_go{0};
  } counts;

  static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
};
using WebSharedPointer = std::shared_ptr<WebShared>;

/// Reads requests of a browser, answers with files, and makes WebSockets of those that ask for one.
void begin_http(const WebSharedPointer& shared, asio::ip::tcp::socket socket);
/// `parts`: long messages are cut (client_queue.hpp).
void begin_live(const WebSharedPointer& shared, beast::tcp_stream stream, Upgrade request, bool parts);
void begin_command(const WebSharedPointer& shared, beast::tcp_stream stream, Upgrade request);

}  // namespace lcmslam

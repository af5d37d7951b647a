#include <lcmslam/web/web_server.hpp>

#include <boost/asio/ip/host_name.hpp>

#include <lcmslam/web/web_core.hpp>

namespace lcmslam {
namespace {

using asio::ip::tcp;

constexpr auto tick = std::chrono::milliseconds(20);
constexpr int send_buffer = 64 * 1024;  // bytes: the system holds no old pictures

/// In an address that is to be opened, also on other machines: of all addresses this machine's name stands
/// for.
std::string host_to_open(const std::string& address) {
  if (address != "0.0.0.0" && address != "::") return address;
  boost::system::error_code error;
  const std::string name = asio::ip::host_name(error);
  return error || name.empty() ? address : name;
}

}  // namespace

class WebServer::Core {
 public:
  Core(const WebSettings& settings, const std::filesystem::path& folder, const Board& board,
       Handlers handlers)
      : shared_(std::make_shared<WebShared>(settings, folder, board, std::move(handlers))),
        io_(std::make_shared<asio::io_context>(1)),
        acceptor_(*io_),
        timer_(*io_) {
    shared_->io = io_;
    listen();
    accept();
    look_after();
    thread_ = std::thread([this] { run(); });
  }

  ~Core() {
    asio::post(*io_, [this] {
      shared_->stopping = true;
      const auto connections = shared_->connections;
      for (const auto& connection : connections) connection->close();
      io_->stop();
    });
    thread_.join();
  }

  const WebShared& shared() const { return *shared_; }
  int port() const { return port_; }

 private:
  void listen() {
    const WebSettings& s = shared_->settings;
    const std::string place = s.address + " port " + std::to_string(s.port);
    try {
      const tcp::endpoint endpoint(asio::ip::make_address(s.address), static_cast<unsigned short>(s.port));
      acceptor_.open(endpoint.protocol());
      acceptor_.set_option(asio::socket_base::reuse_address(true));
      acceptor_.bind(endpoint);
      acceptor_.listen();
      port_ = acceptor_.local_endpoint().port();
    } catch (const boost::system::system_error& error) {
      throw std::runtime_error(
          "no page can be served on " + place + ": " + error.code().message() +
          " (address and port say where, as settings or options; port 0 takes one that is free)");
    }
  }

  /// A request that this machine has no memory for ends, and the others go on.
  void run() {
    while (!io_->stopped()) try {
        io_->run();
      } catch (const std::exception&) {
        ++shared_->counts.bad;
      }
  }

  void accept() {
    is_accepting_ = true;
    acceptor_.async_accept([this](beast::error_code error, tcp::socket socket) {
      is_accepting_ = false;
      if (error) return;  // no more sockets may be opened: the next tick tries again
      accept();
      take(std::move(socket));
    });
  }

  void take(tcp::socket socket) {
    if (shared_->plain >= 4 * shared_->settings.most_clients) {
      ++shared_->counts.too_many;
      if (shared_->reading.empty()) return;  // which closes it
      // Else strangers who say nothing would keep everybody out.
      shared_->reading.front()->give_way();
    }
    beast::error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::send_buffer_size(send_buffer), ignored);
    begin_http(shared_, std::move(socket));
  }

  void look_after() {
    timer_.expires_after(tick);
    timer_.async_wait([this](beast::error_code error) {
      if (error) return;
      look_after();
      if (!is_accepting_) accept();
      const auto connections = shared_->connections;
      for (const auto& connection : connections) connection->tick(WebShared::now());
    });
  }

  WebSharedPointer shared_;
  std::shared_ptr<asio::io_context> io_;
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  bool is_accepting_ = false;
  int port_ = 0;
  std::thread thread_;
};

WebServer::WebServer(const WebSettings& settings, const std::filesystem::path& folder, const Board& board,
                     Handlers handlers)
    : core_(std::make_unique<Core>(settings, folder, board, std::move(handlers))) {}

WebServer::~WebServer() = default;

int WebServer::port() const {
  return core_->port();
}

std::string WebServer::address() const {
  const WebShared& shared = core_->shared();
  const std::string host = host_to_open(shared.settings.address);
  const std::string name = host.find(':') != std::string::npos ? "[" + host + "]" : host;
  const std::string& token = shared.access.token();
  return "http://" + name + ":" + std::to_string(port()) + "/" +
         (token.empty() ? "" : "?token=" + query_value(token));
}

WebCounts WebServer::counts() const {
  const auto& c = core_->shared().counts;
  return {c.clients, c.commands, c.bytes, c.strangers, c.bad, c.too_many, c.let_go};
}

}  // namespace lcmslam

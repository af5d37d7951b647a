#include <lcmslam/web/web_core.hpp>

namespace lcmslam {
namespace {

constexpr auto longest_silence =
    std::chrono::milliseconds(10'000);                   // of a browser that has said half a request
constexpr auto longest_way = std::chrono::seconds(120);  // of a file over a bad link
constexpr std::uint32_t most_header = 8 * 1024;          // bytes
constexpr std::uint64_t most_body = 8 * 1024;

std::string text(beast::string_view view) {
  return {view.data(), view.size()};
}

class HttpConnection : public Reading, public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(WebSharedPointer shared, asio::ip::tcp::socket socket)
      : shared_(std::move(shared)), stream_(std::move(socket)) {
    ++shared_->plain;
  }
  ~HttpConnection() override {
    is_read();
    --shared_->plain;
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(most_header);
    parser_->body_limit(most_body);
    stream_.expires_after(std::min(longest_silence, shared_->patience));
    place_ = shared_->reading.insert(shared_->reading.end(), this);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](beast::error_code error, std::size_t) { self->on_read(error); });
  }

  void give_way() override {
    is_read();
    stream_.close();
  }

 private:
  using Response = http::response<http::string_body>;

  void is_read() {
    if (place_) shared_->reading.erase(*place_);
    place_.reset();
  }

  void on_read(beast::error_code error) {
    is_read();
    if (error) {
      const bool left = error == http::error::end_of_stream || error == beast::error::timeout ||
                        error == asio::error::operation_aborted || error == asio::error::connection_reset;
      if (!left) ++shared_->counts.bad;
      if (error == http::error::header_limit || error == http::error::body_limit)
        return refuse(http::status::payload_too_large, "too large");
      if (error.category() == make_error_code(http::error::bad_method).category() && !left)
        return refuse(http::status::bad_request, "not a request");
      return;
    }
    answer(parser_->release());
  }

  void answer(Upgrade request) {
    Access::Request asked{text(request.target()), text(request[http::field::host]),
                          text(request[http::field::origin]), text(request[http::field::cookie])};
    switch (shared_->access.judge(asked)) {
      case Access::Verdict::wrong_host:
      case Access::Verdict::wrong_origin:
        ++shared_->counts.strangers;
        return refuse(http::status::forbidden, "this page is not for other sites");
      case Access::Verdict::wrong_token:
        ++shared_->counts.strangers;
        return refuse(http::status::unauthorized,
                      "The page wants its token: open the whole address that was printed when it started.");
      case Access::Verdict::granted:
        break;
    }
    if (websocket::is_upgrade(request)) return upgrade(std::move(request), asked);
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      ++shared_->counts.bad;
      return refuse(http::status::method_not_allowed, "files are only read here");
    }
    const StaticFile* file = shared_->files.find(asked.target);
    if (file == nullptr) return refuse(http::status::not_found, "there is no such file");
    send_file(*file, request, shared_->access.names_token(asked) ? shared_->access.cookie(asked) : "");
  }

  void upgrade(Upgrade request, const Access::Request& asked) {
    const std::string path = asked.target.substr(0, asked.target.find('?'));
    if (path != "/live" && path != "/command") return refuse(http::status::not_found, "no such socket");
    const bool is_live = path == "/live";
    if ((is_live ? shared_->live : shared_->command) >= shared_->settings.most_clients) {
      ++shared_->counts.too_many;
      return refuse(http::status::service_unavailable, "too many browsers are here already (most_clients)");
    }
    stream_.expires_never();
    if (!is_live) return begin_command(shared_, std::move(stream_), std::move(request));
    begin_live(shared_, std::move(stream_), std::move(request), query_member(asked.target, "parts") == "1");
  }

  static Response plain(http::status status, const std::string& words) {
    Response response(status, 11);
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    response.body() = words + "\n";
    return response;
  }

  void refuse(http::status status, const std::string& words) { send(plain(status, words), false); }

  void send_file(const StaticFile& file, const Upgrade& request, const std::string& cookie) {
    Response response(http::status::ok, 11);
    response.set(http::field::content_type, file.type);
    response.set(http::field::etag, file.tag);
    response.set(http::field::cache_control, "no-cache");
    response.set(http::field::vary, "Accept-Encoding");
    if (!cookie.empty())
      response.set(http::field::set_cookie, cookie + "; HttpOnly; SameSite=Strict; Path=/");
    if (request[http::field::if_none_match] == file.tag) {
      response.result(http::status::not_modified);
    } else if (!file.packed.empty() &&
               request[http::field::accept_encoding].find("gzip") != beast::string_view::npos) {
      response.set(http::field::content_encoding, "gzip");
      response.body() = file.packed;
    } else {
      response.body() = file.bytes;
    }
    const auto size = response.body().size();
    if (request.method() == http::verb::head) response.body().clear();
    send(std::move(response), request.keep_alive(), size);
  }

  void send(Response response, bool keep_alive, std::optional<std::size_t> size = {}) {
    response.set("Content-Security-Policy",
                 "default-src 'self'; connect-src 'self'; img-src 'self' blob: data:; style-src 'self' "
                 "'unsafe-inline'; "
                 "frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.keep_alive(keep_alive);
    response.content_length(size.value_or(response.body().size()));
    response_ = std::move(response);
    stream_.expires_after(longest_way);
    http::async_write(stream_, *response_,
                      [self = shared_from_this(), keep_alive](beast::error_code error, std::size_t) {
                        if (error) return;
                        if (keep_alive) return self->read();
                        beast::error_code ignored;
                        self->stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
                      });
  }

  WebSharedPointer shared_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{2 * most_header};
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<Response> response_;
  std::optional<std::list<Reading*>::iterator> place_;  // among those who are read
};

}  // namespace

void begin_http(const WebSharedPointer& shared, asio::ip::tcp::socket socket) {
  std::make_shared<HttpConnection>(shared, std::move(socket))->read();
}

}  // namespace lcmslam

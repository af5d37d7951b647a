#include <boost/asio/post.hpp>
#include <nlohmann/json.hpp>

#include <lcmslam/web/web_core.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

constexpr std::size_t most_of_live = 4 * 1024;  // bytes that a browser says at a time
constexpr std::size_t most_of_command = 64 * 1024;
constexpr std::size_t most_unanswered = 64;      // commands, or answers that wait to be taken
constexpr std::size_t most_waiting = 256 << 20;  // bytes of answers
constexpr double slowest_link = 10'000;          // bytes a second

/// What both sockets have in common: one reading and at most one writing at a time.
class SocketConnection : public Connection, public std::enable_shared_from_this<SocketConnection> {
 public:
  SocketConnection(WebSharedPointer shared, beast::tcp_stream stream, std::size_t most)
      : shared_(std::move(shared)), socket_(std::move(stream)), buffer_(most) {
    auto deadlines = websocket::stream_base::timeout::suggested(beast::role_type::server);
    deadlines.handshake_timeout = std::chrono::seconds(10);
    deadlines.idle_timeout = std::chrono::seconds(30);
    deadlines.keep_alive_pings = true;
    socket_.set_option(deadlines);
    socket_.read_message_max(most);
    socket_.auto_fragment(false);
  }

  void begin(Upgrade request) {
    shared_->connections.insert(shared_from_this());
    request_ = std::move(request);
    socket_.async_accept(request_, [self = shared_from_this()](beast::error_code error) {
      if (error) return self->close();
      self->open_ = true;
      self->begun();
      self->read();
    });
  }

  void tick(double now) override {
    if (!writing_) return;
    const double enough = shared_->settings.patience + static_cast<double>(message_->size()) / slowest_link;
    if (now - write_begun_ > enough) let_go();
  }

  void close() override {
    if (closed_) return;
    closed_ = true;
    open_ = false;
    beast::get_lowest_layer(socket_).close();
    ended();
    shared_->connections.erase(shared_from_this());
  }

 protected:
  virtual void begun() {}
  /// Throws for a text that is not understood: the browser is let go.
  virtual void hear(const std::string& text) = 0;
  virtual void ended() = 0;
  /// What is to be sent next; null: nothing now.
  virtual Board::Message next() = 0;

  /// For it takes nothing.
  void let_go() {
    ++shared_->counts.let_go;
    close();
  }

  void write() {
    if (!open_ || writing_) return;
    message_ = next();
    if (!message_) return;
    writing_ = true;
    write_begun_ = WebShared::now();
    socket_.async_write(asio::buffer(*message_),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                          self->writing_ = false;
                          if (error) return self->close();
                          self->write();
                        });
  }

  WebSharedPointer shared_;
  Socket socket_;

 private:
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) {
        const bool left = error == websocket::error::closed;
        if (!left && error.category() == websocket::make_error_code(websocket::error::closed).category())
          ++self->shared_->counts.bad;
        return self->close();
      }
      const std::string text = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      try {
        if (!self->socket_.got_text()) throw std::invalid_argument("texts alone are understood");
        self->hear(text);
      } catch (const std::exception&) {
        ++self->shared_->counts.bad;
        return self->close();
      }
      if (self->open_) self->read();
    });
  }

  Upgrade request_;
  beast::flat_buffer buffer_;
  Board::Message message_;  // under way
  bool open_ = false, closed_ = false, writing_ = false;
  double write_begun_ = 0;
};

class LiveConnection : public SocketConnection {
 public:
  LiveConnection(const WebSharedPointer& shared, beast::tcp_stream stream, bool parts)
      : SocketConnection(shared, std::move(stream), most_of_live),
        queue_(shared->board, parts),
        parts_(parts) {
    ++shared->live;
    ++shared->counts.clients;
    socket_.binary(true);
  }

  void tick(double now) override {
    if (queue_.link().silence(now) > shared_->settings.patience) return let_go();
    SocketConnection::tick(now);
    write();
  }

 private:
  void hear(const std::string& text) override {
    const json said = json::parse(text);
    if (!said.is_object()) throw std::invalid_argument("no object");
    if (said.contains("got") && !said["got"].is_number_unsigned()) throw std::invalid_argument("no count");
    if (said.contains("got")) queue_.acknowledged(said["got"].get<std::uint64_t>(), WebShared::now());
    if (said.contains("eye")) queue_.eye(said["eye"].get<std::array<float, 3>>());
    if (said.contains("want")) queue_.want(said["want"].get<std::set<std::string>>());
    write();
  }

  Board::Message next() override {
    Board::Message message = queue_.next(WebShared::now());
    if (!message && parts_) message = queue_.whole(WebShared::now());
    if (message) shared_->counts.bytes += static_cast<std::int64_t>(message->size());
    return message;
  }

  void ended() override {
    --shared_->live;
    --shared_->counts.clients;
  }

  ClientQueue queue_;
  const bool parts_;
};

class CommandConnection : public SocketConnection {
 public:
  CommandConnection(const WebSharedPointer& shared, beast::tcp_stream stream)
      : SocketConnection(shared, std::move(stream), most_of_command), who_(++shared->last_client) {
    ++shared->command;
    socket_.text(true);
  }

 private:
  void hear(const std::string& text) override {
    if (unanswered_ >= most_unanswered) throw std::runtime_error("too many requests at a time");
    ++unanswered_;
    ++shared_->counts.commands;
    const auto weak = weak_from_this();
    const auto reply = [weak, server = shared_->io](std::string answer) {
      const auto io = server.lock();
      if (!io) return;
      auto message = std::make_shared<const std::string>(std::move(answer));
      asio::post(*io, [weak, message] {
        if (const auto self = std::static_pointer_cast<CommandConnection>(weak.lock())) self->answer(message);
      });
    };
    if (shared_->handlers.command) shared_->handlers.command(who_, text, reply);
  }

  void answer(const Board::Message& message) {
    waiting_ += message->size();
    answers_.push_back(message);
    if (waiting_ > most_waiting && answers_.size() > 1) return let_go();
    write();
  }

  Board::Message next() override {
    if (answers_.empty()) return nullptr;
    Board::Message message = answers_.front();
    answers_.pop_front();
    waiting_ -= message->size();
    --unanswered_;
    return message;
  }

  void ended() override {
    --shared_->command;
    if (!shared_->stopping && shared_->handlers.closed) shared_->handlers.closed(who_);
  }

  const std::uint64_t who_;
  std::size_t unanswered_ = 0;  // commands whose answers are not on their way
  std::size_t waiting_ = 0;     // bytes of answers
  std::deque<Board::Message> answers_;
};

}  // namespace

void begin_live(const WebSharedPointer& shared, beast::tcp_stream stream, Upgrade request, bool parts) {
  std::make_shared<LiveConnection>(shared, std::move(stream), parts)->begin(std::move(request));
}

void begin_command(const WebSharedPointer& shared, beast::tcp_stream stream, Upgrade request) {
  std::make_shared<CommandConnection>(shared, std::move(stream))->begin(std::move(request));
}

}  // namespace lcmslam

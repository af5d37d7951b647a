#pragma once
// A browser's end of HTTP and of WebSockets, as far as tests need it, with a deadline for everything.

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <chrono>
#include <optional>
#include <string>

namespace lcmslam::testing {

class WebClient {
 public:
  explicit WebClient(int port, int receive_buffer = 0) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0)
      setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof(receive_buffer));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ok_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0;
    host_ = "127.0.0.1:" + std::to_string(port);
  }
  ~WebClient() { ::close(socket_); }
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  bool send(const std::string& bytes) {
    return ok_ &&
           ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }

  /// Status line, headers and body; empty when the other end hung up.
  std::string get(const std::string& target, const std::string& headers = "") {
    send("GET " + target + " HTTP/1.1\r\nHost: " + host_ + "\r\n" + headers + "\r\n");
    return response();
  }
  std::string response() {
    while (read_.find("\r\n\r\n") == std::string::npos)
      if (!more()) return read_;
    const std::size_t head = read_.find("\r\n\r\n") + 4;
    const std::size_t length = read_.find("Content-Length: ");
    const std::size_t size = head + (length < head ? std::stoul(read_.substr(length + 16)) : 0);
    while (read_.size() < size)
      if (!more()) break;
    const std::string response = read_.substr(0, size);
    read_.erase(0, std::min(size, read_.size()));
    return response;
  }

  /// True when the server takes the WebSocket.
  bool open_socket(const std::string& target, const std::string& headers = "") {
    return get(target,
               "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                   headers)
               .rfind("HTTP/1.1 101", 0) == 0;
  }
  /// A text, masked with zeros.
  bool say(const std::string& text, unsigned char opcode = 0x81) {
    std::string frame(1, static_cast<char>(opcode));
    if (text.size() < 126) {
      frame += static_cast<char>(0x80 | text.size());
    } else {  // as few bytes as hold the size
      const bool is_long = text.size() > 0xffff;
      frame += static_cast<char>(0x80 | (is_long ? 127 : 126));
      for (int i = is_long ? 7 : 1; i >= 0; --i) frame += static_cast<char>(text.size() >> (8 * i));
    }
    return send(frame + std::string(4, '\0') + text);
  }
  /// The next whole message; nothing when the other end hung up or is silent too long.
  std::optional<std::string> hear() {
    while (true) {
      while (read_.size() < 2)
        if (!more()) return std::nullopt;
      const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(read_[i]); };
      std::size_t size = byte(1) & 127, head = 2;
      const std::size_t extra = size == 126 ? 2 : size == 127 ? 8 : 0;
      while (read_.size() < head + extra)
        if (!more()) return std::nullopt;
      if (extra > 0) {
        size = 0;
        for (std::size_t i = 0; i < extra; ++i) size = size << 8 | byte(2 + i);
        head += extra;
      }
      while (read_.size() < head + size)
        if (!more()) return std::nullopt;
      const int opcode = byte(0) & 15;
      const std::string text = read_.substr(head, size);
      read_.erase(0, head + size);
      if (opcode == 8) return std::nullopt;
      if (opcode == 1 || opcode == 2) return text;
    }
  }
  /// Whether the server hangs up.
  bool is_closed() {
    while (more()) {
    }
    return closed_;
  }

  int patience = 5000;  // ms

 private:
  bool more() {
    pollfd waiting{socket_, POLLIN, 0};
    if (!ok_ || ::poll(&waiting, 1, patience) <= 0) return false;
    char bytes[65536];
    const ssize_t size = ::recv(socket_, bytes, sizeof(bytes), 0);
    closed_ = size <= 0;
    if (size > 0) read_.append(bytes, static_cast<std::size_t>(size));
    return size > 0;
  }

  int socket_;
  bool ok_ = false, closed_ = false;
  std::string host_, read_;
};

}  // namespace lcmslam::testing

#include "tools/launch/control.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <set>
#include <stdexcept>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_request = 200;  // bytes

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

std::vector<fs::path> folders() {
  std::vector<fs::path> all;
  if (const std::string own = variable("RUNTIME_DIRECTORY"); !own.empty()) all.emplace_back(own);
  if (const std::string user = variable("XDG_RUNTIME_DIR"); !user.empty())
    all.push_back(fs::path(user) / "lcmslam");
  all.emplace_back("/tmp/lcmslam-" + std::to_string(getuid()));
  all.emplace_back("/run/lcmslam");
  return all;
}

sockaddr_un address_of(const fs::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path)
    throw std::runtime_error(path.string() +
                             ": is too long for a socket; set XDG_RUNTIME_DIR to a shorter folder");
  std::strcpy(address.sun_path, path.c_str());
  return address;
}

void give_up_after(int socket, int milliseconds) {
  const timeval patience{milliseconds / 1000, 1000 * (milliseconds % 1000)};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
}

bool may_ask(int client) {
  ucred who{};
  socklen_t size = sizeof who;
  return getsockopt(client, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 &&
         (who.uid == 0 || who.uid == geteuid());
}

std::string read_line(int socket, std::size_t most) {
  std::string text;
  char c = 0;
  while (text.size() < most && recv(socket, &c, 1, 0) == 1 && c != '\n') text += c;
  return text;
}

void write_all(int socket, const std::string& text) {
  std::size_t sent = 0;
  while (sent < text.size()) {
    const ssize_t n = ::send(socket, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n <= 0) return;
    sent += static_cast<std::size_t>(n);
  }
}

/// -1 when nobody listens there. `kind`: further flags of socket().
int connect_to(const fs::path& path, int kind = 0) {
  const sockaddr_un address = address_of(path);
  const int client = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | kind, 0);
  if (client < 0) return -1;
  if (connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return client;
  const int error = errno;
  close(client);
  errno = error;
  return -1;
}

}  // namespace

fs::path control_folder() {
  const fs::path folder = folders().front();
  std::error_code ignored;
  fs::create_directories(folder.parent_path(), ignored);
  mkdir(folder.c_str(), 0700);
  struct stat state {};
  if (lstat(folder.c_str(), &state) != 0)
    throw std::runtime_error(folder.string() + ": " + std::strerror(errno));
  if (!S_ISDIR(state.st_mode) || state.st_uid != geteuid() || (state.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    throw std::runtime_error(folder.string() +
                             ": must be a folder of this user that nobody else may write to");
  return folder;
}

ControlSocket::ControlSocket(const fs::path& folder, const std::string& name)
    : path_(folder / (name + "-" + std::to_string(getpid()) + ".sock")) {
  const sockaddr_un address = address_of(path_);
  unlink(path_.c_str());  // of a process that had this number before
  socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const mode_t before = umask(0177);
  const bool bound =
      socket_ >= 0 && bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const int error = errno;
  umask(before);
  if (bound && ::listen(socket_, 8) == 0) return;
  if (socket_ >= 0) close(socket_);
  throw std::runtime_error(path_.string() + ": " + std::strerror(error));
}

ControlSocket::~ControlSocket() {
  unlink(path_.c_str());  // first: one that refuses and is there is a dead process's
  close(socket_);
}

void ControlSocket::poll(const Answer& answer) {
  const int client = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  give_up_after(client, 200);
  if (may_ask(client)) write_all(client, answer(read_line(client, longest_request)));
  close(client);
}

std::vector<fs::path> running_launches() {
  std::set<fs::path> sockets;
  std::error_code error;
  for (const fs::path& folder : folders())
    for (const auto& entry : fs::directory_iterator(folder, error))
      if (entry.path().extension() == ".sock") sockets.insert(entry.path());
  std::vector<fs::path> running;
  for (const fs::path& socket : sockets) {
    if (is_listened_to(socket))
      running.push_back(socket);
    else if (errno == ECONNREFUSED)
      unlink(socket.c_str());
  }
  return running;
}

bool is_listened_to(const fs::path& socket) {
  const int client = connect_to(socket, SOCK_NONBLOCK);
  if (client < 0) return errno == EAGAIN;  // it has not come to those who asked before
  close(client);
  return true;
}

std::optional<std::string> ask_launch(const fs::path& socket, const std::string& request) {
  const int server = connect_to(socket);
  if (server < 0) return std::nullopt;
  give_up_after(server, 10'000);
  write_all(server, request + "\n");
  std::string answer;
  char buffer[4096];
  for (ssize_t n = 0; (n = recv(server, buffer, sizeof buffer, 0)) > 0;)
    answer.append(buffer, static_cast<std::size_t>(n));
  close(server);
  if (answer.empty()) return std::nullopt;
  return answer;
}

}  // namespace lcmslam

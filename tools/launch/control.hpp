#pragma once
// Words with a running `lcmslam launch` from another terminal: a socket in a folder that only this user may
// enter, a line of request, a text of answer. Whoever else reaches it (root does) is asked for by the kernel:
// only the same user and root are answered.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lcmslam {

/// $RUNTIME_DIRECTORY (systemd's), $XDG_RUNTIME_DIR/lcmslam, or /tmp/lcmslam-UID; made where it is not there.
/// Throws std::runtime_error when it is somebody else's or open to others.
std::filesystem::path control_folder();

class ControlSocket {
 public:
  using Answer = std::function<std::string(const std::string& request)>;

  /// `name` tells it from others in the folder. Throws std::runtime_error.
  ControlSocket(const std::filesystem::path& folder, const std::string& name);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  /// Answers who waits; never waits for long itself.
  void poll(const Answer& answer);

 private:
  std::filesystem::path path_;
  int socket_ = -1;
};

/// Sockets of launches that run, in all folders where they may be; those of dead ones are removed.
std::vector<std::filesystem::path> running_launches();

/// Whether its process lives, however busy it is.
bool is_listened_to(const std::filesystem::path& socket);

/// The answer of a launch; nothing when it does not answer.
std::optional<std::string> ask_launch(const std::filesystem::path& socket, const std::string& request);

}  // namespace lcmslam

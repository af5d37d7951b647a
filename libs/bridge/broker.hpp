#pragma once
// Which broker, and how it is to be spoken to.

#include <filesystem>
#include <string>

namespace lcmslam::bridge {

struct Broker {
  std::string host = "localhost";
  int port = 1883;
  std::string certificates;      ///< file or folder of the authorities that are trusted; empty: no TLS
  std::string certificate, key;  ///< files, of this bridge; empty: none
  std::string user, password;
  std::string id;             ///< of this bridge at the broker
  double longest_pause = 30;  ///< s between two attempts to connect
};

/// localhost, 127.0.0.0/8 and ::1.
bool is_this_machine(const std::string& host);

/// Why this broker is not to be spoken to; empty: it may be. What leaves the machine must be encrypted, and
/// each side must know the other.
std::string objection(const Broker& broker);

/// First line of a file that nobody but its owner may read. Throws std::invalid_argument.
std::string read_password(const std::filesystem::path& file);

/// The connection, in a thread of its own.
class BrokerLink {
 public:
  virtual ~BrokerLink() = default;
  /// In words: "connected to ...", "no connection: ...".
  virtual std::string state() const = 0;
};

}  // namespace lcmslam::bridge

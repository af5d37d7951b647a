#pragma once
// What echo prints for a message.

#include <map>
#include <optional>

#include <lcmslam/messages/parts.hpp>
#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {

struct EchoOptions {
  bool json = false;                      ///< a line of JSON a message
  bool full = false;                      ///< nothing is abridged
  bool pieces = false;                    ///< shows pieces as such; otherwise they are put together
  std::vector<const MessageType*> types;  ///< known besides those of lcmtypes/
};

class EchoPrinter {
 public:
  explicit EchoPrinter(EchoOptions options) : options_(std::move(options)) {}

  /// The text for a message, whatever its bytes; nothing for a piece that completes no message.
  std::optional<std::string> print(const std::string& channel, const std::uint8_t* data, std::size_t size);

 private:
  std::string print_whole(const std::string& channel, const std::uint8_t* data, std::size_t size) const;
  const MessageType* find(std::uint64_t fingerprint) const;

  EchoOptions options_;
  std::map<std::string, PartAssembler> assemblers_;
};

/// LCM's pattern for these channels and for those that carry their messages in pieces.
std::string echo_pattern(const std::string& channels);

}  // namespace lcmslam

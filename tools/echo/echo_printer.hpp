#pragma once
// What echo prints for a message.

#include <map>
#include <optional>

#include <lcmslam/messages/parts.hpp>
#include "tools/echo/csv_table.hpp"
#include "tools/log/definition_files.hpp"

namespace lcmslam {

struct EchoOptions {
  bool json = false;    ///< a line of JSON a message
  bool csv = false;     ///< a row a message, below a row of names
  bool full = false;    ///< nothing is abridged
  bool pieces = false;  ///< shows pieces as such; otherwise they are put together
  KnownTypes types;
};

class EchoPrinter {
 public:
  explicit EchoPrinter(EchoOptions options) : options_(std::move(options)) {}

  /// The text for a message, whatever its bytes; nothing for a piece that completes no message. Throws
  /// std::runtime_error for a message that fits into no row of CSV.
  std::optional<std::string> print(const std::string& channel, const std::uint8_t* data, std::size_t size);

 private:
  std::string print_whole(const std::string& channel, const std::uint8_t* data, std::size_t size);

  EchoOptions options_;
  CsvTable table_;
  std::map<std::string, PartAssembler> assemblers_;
};

/// LCM's pattern for these channels and for those that carry their messages in pieces.
std::string echo_pattern(const std::string& channels);

}  // namespace lcmslam

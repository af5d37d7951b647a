#pragma once
// Messages of one type as rows of CSV (RFC 4180).

#include <string>

#include <lcmslam/messages/message_value.hpp>

namespace lcmslam {

/// Columns: the channel, then each number and text of the message, of nested types as `member.member` and of
/// arrays of fixed size as `member[0]`. Arrays whose size varies, and bytes, are left out: rows have one
/// length.
class CsvTable {
 public:
  /// The message's row, before the first one the row of names. Throws std::runtime_error when the type is not
  /// known (nullptr), is another than that of the rows before, or does not fit the bytes.
  std::string row(const std::string& channel, const MessageType* type, const std::uint8_t* data,
                  std::size_t size);

 private:
  const MessageType* type_ = nullptr;  // of all rows
};

}  // namespace lcmslam

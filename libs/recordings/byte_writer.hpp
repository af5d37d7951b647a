#pragma once
// Little-endian numbers and texts one after another.

#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include <lcmslam/recordings/byte_reader.hpp>

namespace lcmslam {

class ByteWriter {
 public:
  template <class T>
  void number(T value) {
    static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they are");
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
  }
  void raw(ByteView bytes) { bytes_.insert(bytes_.end(), bytes.data, bytes.data + bytes.size); }
  void raw(std::string_view text) { bytes_.insert(bytes_.end(), text.begin(), text.end()); }
  /// Behind its length in 4 bytes.
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    raw(text);
  }

  void clear() { bytes_.clear(); }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  ByteView view() const { return {bytes_.data(), bytes_.size()}; }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace lcmslam

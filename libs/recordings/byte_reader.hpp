#pragma once
// Little-endian numbers and texts one after another, none of them read beyond the end.

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

namespace lcmslam {

/// Bytes of a recording that are not what they should be: says what, and what would be right.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bytes that lie elsewhere.
struct ByteView {
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;

  std::string_view text() const { return {reinterpret_cast<const char*>(data), size}; }
};

class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : bytes_(bytes) {}

  std::size_t position() const { return at_; }
  std::size_t left() const { return bytes_.size - at_; }
  bool done() const { return left() == 0; }

  /// Throws RecordingError when so much is not there.
  ByteView take(std::uint64_t size) {
    if (size > left())
      throw RecordingError(std::to_string(size) + " bytes are said to follow, but only " +
                           std::to_string(left()) + " do");
    const ByteView taken{bytes_.data + at_, static_cast<std::size_t>(size)};
    at_ += taken.size;
    return taken;
  }

  template <class T>
  T number() {
    static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they are");
    T value;
    std::memcpy(&value, take(sizeof(T)).data, sizeof(T));
    return value;
  }

  /// Bytes behind their length, a number of type Size.
  template <class Size>
  ByteView sized() {
    return take(number<Size>());
  }
  std::string text() { return std::string(sized<std::uint32_t>().text()); }

 private:
  ByteView bytes_;
  std::size_t at_ = 0;
};

}  // namespace lcmslam

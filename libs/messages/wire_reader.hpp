#pragma once
// Reads LCM's wire format (big-endian) and never beyond the end.

#include <cstring>

#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

class WireReader {
 public:
  WireReader(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

  /// Signed big-endian integer of 1, 2, 4 or 8 bytes.
  std::int64_t integer(std::size_t bytes, const std::string& name) {
    need(bytes, name);
    std::uint64_t value = (*at_ & 0x80) ? ~std::uint64_t{0} : 0;
    for (std::size_t i = 0; i < bytes; ++i) value = (value << 8) | *at_++;
    return static_cast<std::int64_t>(value);
  }

  void skip(std::size_t count, std::size_t size, const std::string& name) {
    if (count > left() / size) need(left() + 1, name);
    at_ += count * size;
  }

  std::string bytes(std::size_t count, const std::string& name) {
    need(count, name);
    std::string value(reinterpret_cast<const char*>(at_), count);
    at_ += count;
    return value;
  }

  float real32(const std::string& name) { return real<float, std::uint32_t>(name); }
  double real64(const std::string& name) { return real<double, std::uint64_t>(name); }

  /// A string is its length with the final NUL, then the bytes.
  std::string text(const std::string& name) {
    const std::int64_t length = integer(4, name);
    if (length < 1 || static_cast<std::uint64_t>(length) > left() || at_[length - 1] != 0)
      throw DecodeError(name + ": text of length " + std::to_string(length) + " does not fit");
    // LCM's encoders stop at the first NUL: such a text could not be sent on.
    if (std::memchr(at_, 0, static_cast<std::size_t>(length - 1)) != nullptr)
      throw DecodeError(name + ": text with a NUL in it");
    std::string value(reinterpret_cast<const char*>(at_), static_cast<std::size_t>(length - 1));
    at_ += length;
    return value;
  }

 private:
  template <class Real, class Bits>
  Real real(const std::string& name) {
    static_assert(sizeof(Real) == sizeof(Bits));
    const auto bits = static_cast<Bits>(integer(sizeof(Bits), name));
    Real value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  void need(std::size_t bytes, const std::string& name) const {
    if (bytes > left()) throw DecodeError("message ends before " + name);
  }

  const std::uint8_t* at_;
  const std::uint8_t* end_;
};

}  // namespace lcmslam

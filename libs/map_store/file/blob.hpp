#pragma once
// Bytes as the map file's rows hold them: numbers in little-endian order, the kind of the blob in front, a
// checksum behind. SQLite notices a page that is not whole; a bit that flipped in one is noticed here.

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace lcmslam {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "blobs are written as this machine has numbers");

using Blob = std::vector<std::uint8_t>;

/// A blob that is damaged or of another kind; says how.
class BlobError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The first byte of each blob. Another form of the same content takes a new number, so that old files can
/// be read.
enum class BlobKind : std::uint8_t {
  pose = 1,
  edge = 2,
  landmark = 3,
  trajectory = 4,
  cloud = 5,
  features = 6,
  calibration = 7,
  covariance = 8,
  images = 9
};

class BlobWriter {
 public:
  template <class Number>
  void put(Number number) {
    static_assert(std::is_arithmetic_v<Number>);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof number);
    std::memcpy(bytes_.data() + at, &number, sizeof number);
  }
  /// Room for `size` bytes, to be filled before the next call.
  std::uint8_t* grow(std::size_t size) {
    bytes_.resize(bytes_.size() + size);
    return bytes_.data() + bytes_.size() - size;
  }

  /// The kind, what was put, and the checksum. `packed`: deflated in between.
  Blob seal(BlobKind kind, bool packed) const;

 private:
  Blob bytes_;
};

class BlobReader {
 public:
  /// What a blob of this kind holds. Throws BlobError unless kind and checksum are right.
  BlobReader(const Blob& blob, BlobKind kind, bool packed);

  /// Throws BlobError where the blob has ended.
  template <class Number>
  Number take() {
    Number number;
    std::memcpy(&number, take_bytes(sizeof number), sizeof number);
    return number;
  }
  const std::uint8_t* take_bytes(std::size_t size) {
    if (size > left()) throw BlobError("the blob ends too early");
    at_ += size;
    return bytes_.data() + at_ - size;
  }
  std::size_t left() const { return bytes_.size() - at_; }
  /// Throws BlobError unless all was taken.
  void expect_end() const;

 private:
  Blob bytes_;
  std::size_t at_ = 0;
};

}  // namespace lcmslam

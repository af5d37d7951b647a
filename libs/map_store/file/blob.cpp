#include <lcmslam/map_store/file/blob.hpp>

#include <libdeflate.h>
#include <algorithm>
#include <memory>

namespace lcmslam {
namespace {

constexpr int level = 4;               // twice as fast as 6, a few per cent larger
constexpr std::size_t seal_bytes = 5;  // kind and checksum
// No deflated bytes become more than so many: who claims it is damaged, and would take memory without bounds.
constexpr std::size_t largest_ratio = 1040;

struct FreeDeflate {
  void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
  void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

std::uint32_t checksum(const std::uint8_t* bytes, std::size_t size) {
  return libdeflate_crc32(0, bytes, size);
}

/// Appends the size of what is packed, and that, deflated.
void append_deflated(Blob& blob, const Blob& bytes) {
  thread_local const std::unique_ptr<libdeflate_compressor, FreeDeflate> deflate(
      libdeflate_alloc_compressor(level));
  const auto size = static_cast<std::uint32_t>(bytes.size());
  if (size != bytes.size()) throw std::length_error("a blob holds at most 4 GB");
  const std::size_t at = blob.size() + sizeof size;
  blob.resize(at + libdeflate_deflate_compress_bound(deflate.get(), bytes.size()));
  std::memcpy(blob.data() + at - sizeof size, &size, sizeof size);
  blob.resize(at + libdeflate_deflate_compress(deflate.get(), bytes.data(), bytes.size(), blob.data() + at,
                                               blob.size() - at));
}

Blob inflate(const std::uint8_t* bytes, std::size_t size) {
  thread_local const std::unique_ptr<libdeflate_decompressor, FreeDeflate> deflate(
      libdeflate_alloc_decompressor());
  std::uint32_t claimed = 0;
  if (size < sizeof claimed) throw BlobError("the blob ends too early");
  std::memcpy(&claimed, bytes, sizeof claimed);
  size -= sizeof claimed;
  if (claimed > largest_ratio * (size + 1)) throw BlobError("the blob claims more than it can hold");
  Blob result(claimed);
  std::size_t written = 0;
  const auto status = libdeflate_deflate_decompress(deflate.get(), bytes + sizeof claimed, size,
                                                    result.data(), result.size(), &written);
  if (status != LIBDEFLATE_SUCCESS || written != claimed) throw BlobError("the blob does not inflate");
  return result;
}

}  // namespace

Blob BlobWriter::seal(BlobKind kind, bool packed) const {
  Blob blob(1, static_cast<std::uint8_t>(kind));
  if (packed) {
    append_deflated(blob, bytes_);
  } else {
    blob.resize(1 + bytes_.size());
    std::copy(bytes_.begin(), bytes_.end(), blob.begin() + 1);
  }
  const std::uint32_t sum = checksum(blob.data(), blob.size());
  blob.resize(blob.size() + sizeof sum);
  std::memcpy(blob.data() + blob.size() - sizeof sum, &sum, sizeof sum);
  return blob;
}

BlobReader::BlobReader(const Blob& blob, BlobKind kind, bool packed) {
  if (blob.size() < seal_bytes) throw BlobError("the blob ends too early");
  if (blob[0] != static_cast<std::uint8_t>(kind))
    throw BlobError("the blob is of kind " + std::to_string(blob[0]) + ", expected " +
                    std::to_string(static_cast<int>(kind)));
  std::uint32_t sum = 0;
  const std::size_t end = blob.size() - sizeof sum;
  std::memcpy(&sum, blob.data() + end, sizeof sum);
  if (sum != checksum(blob.data(), end)) throw BlobError("the blob's checksum is wrong");
  if (packed)
    bytes_ = inflate(blob.data() + 1, end - 1);
  else
    bytes_.assign(blob.begin() + 1, blob.begin() + static_cast<std::ptrdiff_t>(end));
}

void BlobReader::expect_end() const {
  if (left() > 0) throw BlobError("the blob is longer than its content");
}

}  // namespace lcmslam

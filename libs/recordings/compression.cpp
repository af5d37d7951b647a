#include <lcmslam/recordings/compression.hpp>

#include <bzlib.h>
#include <libdeflate.h>
#include <lz4frame.h>
#include <zstd.h>
#include <algorithm>
#include <functional>
#include <memory>
#include <new>

namespace lcmslam {
namespace {

/// What one call of a library did.
struct Progress {
  std::size_t read = 0, written = 0;
  bool finished = false;  // the end that the format itself marks
};
using Step = std::function<Progress(ByteView packed, std::uint8_t* out, std::size_t room)>;

constexpr std::size_t first_room = 1 << 20;

/// Calls `step` until the format's end; the room doubles as it fills.
std::vector<std::uint8_t> unpack_by(const Step& step, ByteView packed, std::uint64_t size) {
  std::vector<std::uint8_t> out;
  std::size_t written = 0;
  for (bool finished = false; !finished;) {
    if (written == out.size() && written < size)
      out.resize(static_cast<std::size_t>(std::min<std::uint64_t>(size, std::max(first_room, 2 * written))));
    const Progress progress = step(packed, out.data() + written, out.size() - written);
    packed.data += progress.read;
    packed.size -= progress.read;
    written += progress.written;
    finished = progress.finished;
    if (!finished && progress.read == 0 && progress.written == 0)
      throw RecordingError(written == size ? "more bytes come out of it than the " + std::to_string(size) +
                                                 " that it is said to hold"
                                           : "its compressed bytes end too early");
  }
  if (written != size)
    throw RecordingError(std::to_string(written) + " bytes come out of it, it is said to hold " +
                         std::to_string(size));
  return out;
}

[[noreturn]] void damaged(const std::string& reason) {
  throw RecordingError("its compressed bytes are damaged: " + reason);
}

std::vector<std::uint8_t> unpack_lz4(ByteView packed, std::uint64_t size) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, LZ4F_freeDecompressionContext);
  return unpack_by(
      [&](ByteView in, std::uint8_t* out, std::size_t room) {
        std::size_t read = in.size, written = room;
        const std::size_t hint = LZ4F_decompress(context.get(), out, &written, in.data, &read, nullptr);
        if (LZ4F_isError(hint) != 0) damaged(LZ4F_getErrorName(hint));
        return Progress{read, written, hint == 0};
      },
      packed, size);
}

std::vector<std::uint8_t> unpack_zstd(ByteView packed, std::uint64_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  int window = 23;  // 8 MiB, which every decoder must bear; more only for as much as there is to come out
  while (window < 27 && (std::uint64_t{1} << window) < size) ++window;
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, window);
  return unpack_by(
      [&](ByteView packed_now, std::uint8_t* bytes, std::size_t room) {
        ZSTD_inBuffer in{packed_now.data, packed_now.size, 0};
        ZSTD_outBuffer out{bytes, room, 0};
        const std::size_t hint = ZSTD_decompressStream(context.get(), &out, &in);
        if (ZSTD_isError(hint) != 0) damaged(ZSTD_getErrorName(hint));
        return Progress{in.pos, out.pos, hint == 0};
      },
      packed, size);
}

std::vector<std::uint8_t> unpack_bz2(ByteView packed, std::uint64_t size) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> ended(&stream, BZ2_bzDecompressEnd);
  return unpack_by(
      [&](ByteView in, std::uint8_t* out, std::size_t room) {
        constexpr std::size_t most = 1U << 30;  // its counters have 32 bits
        const auto in_size = static_cast<unsigned>(std::min(in.size, most));
        const auto out_size = static_cast<unsigned>(std::min(room, most));
        stream.next_in =
            const_cast<char*>(reinterpret_cast<const char*>(in.data));  // it does not write there
        stream.avail_in = in_size;
        stream.next_out = reinterpret_cast<char*>(out);
        stream.avail_out = out_size;
        const int status = BZ2_bzDecompress(&stream);
        if (status != BZ_OK && status != BZ_STREAM_END) damaged("bz2's error " + std::to_string(status));
        return Progress{in_size - stream.avail_in, out_size - stream.avail_out, status == BZ_STREAM_END};
      },
      packed, size);
}

}  // namespace

std::vector<std::uint8_t> unpack(const std::string& compression, ByteView packed, std::uint64_t size) {
  if (compression == "lz4") return unpack_lz4(packed, size);
  if (compression == "zstd") return unpack_zstd(packed, size);
  if (compression == "bz2") return unpack_bz2(packed, size);
  if (!compression.empty() && compression != "none")
    throw RecordingError("its compression '" + compression +
                         "' is not known: must be lz4, zstd, bz2 or none");
  if (packed.size != size)
    throw RecordingError("it has " + std::to_string(packed.size) + " bytes, it is said to hold " +
                         std::to_string(size));
  return {packed.data, packed.data + packed.size};
}

std::vector<std::uint8_t> pack(const std::string& compression, ByteView bytes) {
  std::vector<std::uint8_t> packed;
  if (compression == "zstd") {
    packed.resize(ZSTD_compressBound(bytes.size));
    const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data, bytes.size, 1);
    if (ZSTD_isError(size) != 0) throw std::runtime_error(ZSTD_getErrorName(size));
    packed.resize(size);
  } else if (compression == "lz4") {
    packed.resize(LZ4F_compressFrameBound(bytes.size, nullptr));
    const std::size_t size =
        LZ4F_compressFrame(packed.data(), packed.size(), bytes.data, bytes.size, nullptr);
    if (LZ4F_isError(size) != 0) throw std::runtime_error(LZ4F_getErrorName(size));
    packed.resize(size);
  } else if (compression.empty()) {
    packed.assign(bytes.data, bytes.data + bytes.size);
  } else {
    throw std::invalid_argument("compression '" + compression + "': must be zstd, lz4 or empty");
  }
  return packed;
}

std::uint32_t crc32(ByteView bytes, std::uint32_t before) {
  if (bytes.size == 0) return before;  // libdeflate begins anew where there are no bytes
  return libdeflate_crc32(before, bytes.data, bytes.size);
}

}  // namespace lcmslam

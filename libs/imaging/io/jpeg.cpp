#include <lcmslam/imaging/io/jpeg.hpp>

#include <turbojpeg.h>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {
namespace {

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<std::remove_pointer_t<tjhandle>, Destroy>;

Handle decompressor() {
  Handle handle(tjInitDecompress());
  if (!handle) throw std::runtime_error("libjpeg-turbo: cannot make a decompressor");
  return handle;
}

ImageSize read_header(tjhandle handle, const std::vector<std::uint8_t>& bytes) {
  ImageSize size;
  int subsampling = 0;
  int colourspace = 0;
  if (bytes.empty() || tjDecompressHeader3(handle, bytes.data(), bytes.size(), &size.width, &size.height,
                                           &subsampling, &colourspace) != 0)
    throw CodecError(bytes.empty() ? std::string("JPEG without bytes")
                                   : std::string("JPEG header: ") + tjGetErrorStr2(handle));
  return size;
}

// Some USB cameras pad their frames: the picture is whole all the same.
bool is_harmless(tjhandle handle) {
  return tjGetErrorCode(handle) == TJERR_WARNING &&
         std::strstr(tjGetErrorStr2(handle), "extraneous bytes") != nullptr;
}

}  // namespace

ImageSize jpeg_size(const std::vector<std::uint8_t>& bytes) {
  return read_header(decompressor().get(), bytes);
}

std::size_t jpeg_bytes(const std::uint8_t* data, std::size_t size) {
  constexpr std::uint8_t begin = 0xd8, scan = 0xda, end = 0xd9;
  if (size < 4 || data[0] != 0xff || data[1] != begin) throw CodecError("no JPEG: it begins otherwise");
  for (std::size_t at = 2; at + 4 <= size && data[at] == 0xff;) {  // segments, each with its length
    const bool image_follows = data[at + 1] == scan;
    at += 2 + 256 * std::size_t{data[at + 2]} + data[at + 3];
    if (!image_follows) continue;
    for (; at + 2 <= size; ++at)  // within a scan 0xff is followed by 0
      if (data[at] == 0xff && data[at + 1] == end) return at + 2;
  }
  throw CodecError("the JPEG has no end: it is cut off");
}

cv::Mat decode_jpeg(const std::vector<std::uint8_t>& bytes, ImageSize declared, bool gray) {
  const Handle handle = decompressor();
  const ImageSize size = read_header(handle.get(), bytes);
  if (size.width != declared.width || size.height != declared.height)
    throw CodecError("JPEG is " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                     " pixels, declared are " + std::to_string(declared.width) + "x" +
                     std::to_string(declared.height));
  cv::Mat image(size.height, size.width, gray ? CV_8UC1 : CV_8UC3);
  if (tjDecompress2(handle.get(), bytes.data(), bytes.size(), image.data, size.width,
                    static_cast<int>(image.step), size.height, gray ? TJPF_GRAY : TJPF_BGR,
                    TJFLAG_LIMITSCANS) != 0 &&
      !is_harmless(handle.get()))
    throw CodecError(std::string("JPEG data: ") + tjGetErrorStr2(handle.get()));
  return image;
}

std::vector<std::uint8_t> encode_jpeg(const cv::Mat& image, int quality) {
  if (image.empty() || (image.type() != CV_8UC3 && image.type() != CV_8UC1))
    throw std::invalid_argument("encode_jpeg: the image must be CV_8UC3 or CV_8UC1 and not empty");
  if (quality < 1 || quality > 100) throw std::invalid_argument("encode_jpeg: quality must be 1 to 100");
  const bool gray = image.type() == CV_8UC1;
  const int subsampling = gray ? TJSAMP_GRAY : TJSAMP_420;
  const Handle handle(tjInitCompress());
  if (!handle) throw std::runtime_error("libjpeg-turbo: cannot make a compressor");
  std::vector<std::uint8_t> bytes(tjBufSize(image.cols, image.rows, subsampling));
  unsigned char* target = bytes.data();
  unsigned long size = bytes.size();
  if (tjCompress2(handle.get(), image.data, image.cols, static_cast<int>(image.step), image.rows,
                  gray ? TJPF_GRAY : TJPF_BGR, &target, &size, subsampling, quality,
                  TJFLAG_NOREALLOC | TJFLAG_ACCURATEDCT) != 0)
    throw std::runtime_error(std::string("JPEG encoding: ") + tjGetErrorStr2(handle.get()));
  bytes.resize(size);
  return bytes;
}

}  // namespace lcmslam

#include <lcmslam/surface/kept_view.hpp>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/surface/depth_deltas.hpp>

namespace lcmslam {

constexpr int kept_quality = 80;  // of JPEG: colours are averaged over several looks

namespace {

/// Encoders leave room for the worst image.
EncodedImage trimmed(EncodedImage image) {
  image.bytes.shrink_to_fit();
  return image;
}

}  // namespace

KeptView::KeptView(const SurfaceImage& image)
    : depth_(pack_depth(image.depth)),
      colour_(trimmed(encode_colour(image.colour, 0, kept_quality))),
      seen_(trimmed(encode_amplitude(image.seen, 0))),
      T_camera_depth_(image.T_camera_depth) {
  if (!image.amplitude.empty()) amplitude_ = trimmed(encode_amplitude(image.amplitude, 0));
}

SurfaceImage KeptView::unpacked() const {
  SurfaceImage image;
  image.depth = unpack_depth(depth_, {seen_.width, seen_.height});
  if (amplitude_.coding != ImageCoding::none) image.amplitude = decode_gray(amplitude_);
  image.colour = decode_colour(colour_);
  image.seen = decode_gray(seen_);
  image.T_camera_depth = T_camera_depth_;
  return image;
}

std::size_t KeptView::memory_bytes() const {
  return sizeof(KeptView) + depth_.capacity() + amplitude_.bytes.capacity() + colour_.bytes.capacity() +
         seen_.bytes.capacity();
}

}  // namespace lcmslam

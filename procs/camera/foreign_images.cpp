#include "procs/camera/foreign_images.hpp"

#include <cstdio>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/jpeg.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include "procs/camera/drivers/wall_clock.hpp"

namespace lcmslam {
namespace {

constexpr Utime time_began_anew = 1'000'000;  // us back

/// JPEG, whatever it was. A JPEG's own header must agree with the message's.
void compress_colour(EncodedImage& image, int quality) {
  if (image.coding != ImageCoding::jpeg) {
    image = encode_colour(decode_colour(image), image.utime, quality);
    return;
  }
  image.bytes.resize(jpeg_bytes(image.bytes.data(), image.bytes.size()));
  const ImageSize size = jpeg_size(image.bytes);
  if (size.width != image.width || size.height != image.height)
    throw CodecError("the colour image says that it is " + std::to_string(image.width) + "x" +
                     std::to_string(image.height) + ", its JPEG is " + std::to_string(size.width) + "x" +
                     std::to_string(size.height));
}

void compress_depth(EncodedImage& image) {
  if (image.coding == ImageCoding::depth_raw) image = encode_depth(decode_depth(image), image.utime);
}

}  // namespace

ForeignImages::ForeignImages(std::string channel, const RgbdCalibration& calibration,
                             const LiveSettings& settings, Clock clock)
    : channel_(std::move(channel)),
      calibration_(calibration),
      settings_(settings),
      clock_(std::move(clock)),
      last_(clock_()) {}

std::optional<EncodedFrame> ForeignImages::relay(const images_t& message) {
  try {
    EncodedFrame frame = checked_images(message, calibration_);
    if (frame.utime == 0) frame.utime = wall_clock();
    for (EncodedImage* image : {&frame.colour, &frame.depth, &frame.amplitude})
      if (image->utime == 0) image->utime = frame.utime;
    compress_colour(frame.colour, settings_.jpeg_quality);
    compress_depth(frame.depth);
    if (frame.utime <= last_utime_ && frame.utime > last_utime_ - time_began_anew)
      throw CodecError("an image of " + std::to_string(last_utime_ - frame.utime) +
                       " us before the last one: stamps must rise");
    last_utime_ = frame.utime;
    frame.sensor = calibration_.sensor;
    dropped_ += gaps_.missing_before(frame.utime);
    last_ = clock_();
    misfit_.clear();
    ++relayed_;
    return frame;
  } catch (const DecodeError& error) {
    misfit_ = error.what();
  } catch (const CodecError& error) {
    misfit_ = error.what();
  }
  ++refused_;
  return std::nullopt;
}

SourceHealth ForeignImages::health() const {
  SourceHealth health;
  health.values = {{"relayed", static_cast<double>(relayed_)},
                   {"refused", static_cast<double>(refused_)},
                   {"dropped", static_cast<double>(dropped_)}};
  const std::chrono::duration<double> since = clock_() - last_;
  health.silent = since.count() > settings_.watch.late_after;
  if (!misfit_.empty()) {
    health.trouble = channel_ + ": " + misfit_;
  } else if (health.silent) {
    char text[64];
    std::snprintf(text, sizeof text, ": no image for %.1f s", since.count());
    health.trouble = channel_ + text;
  }
  return health;
}

}  // namespace lcmslam

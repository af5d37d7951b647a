#include <lcmslam/messages/camera_messages.hpp>

#include <charconv>
#include <string_view>

#include <lcmslam/imaging/constant_depth.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

constexpr int largest_side = 8192;     // pixels
constexpr int big_endian_depth = 357;  // bot_core's PIXEL_FORMAT_BE_GRAY16

image_t make_image(const EncodedImage& image, int pixelformat, int bytes_per_pixel) {
  image_t message;
  message.utime = image.utime;
  message.width = image.width;
  message.height = image.height;
  message.row_stride = image.width * bytes_per_pixel;
  message.pixelformat = pixelformat;
  message.size = static_cast<int32_t>(image.bytes.size());
  message.data = image.bytes;
  message.nmetadata = 0;
  return message;
}

void add(images_t& message, std::int16_t type, image_t image) {
  message.image_types.push_back(type);
  message.images.push_back(std::move(image));
  message.n_images = static_cast<int32_t>(message.images.size());
}

/// The rows of an uncompressed image back to back: drivers may have padded each.
std::vector<std::uint8_t> packed_rows(const image_t& message, std::size_t row) {
  const auto stride = static_cast<std::size_t>(message.row_stride);
  std::vector<std::uint8_t> packed;
  packed.reserve(row * static_cast<std::size_t>(message.height));
  for (int v = 0; v < message.height; ++v) {
    const std::uint8_t* begin = message.data.data() + static_cast<std::size_t>(v) * stride;
    packed.insert(packed.end(), begin, begin + row);
  }
  return packed;
}

EncodedImage read_image(const image_t& message, ImageCoding coding, std::size_t raw_pixel_bytes) {
  check_range(static_cast<double>(message.utime), -1e17, 1e17, "image utime");
  check_range(message.width, 1, largest_side, "image width");
  check_range(message.height, 1, largest_side, "image height");
  if (raw_pixel_bytes == 0) return {message.utime, message.width, message.height, coding, message.data};
  const std::size_t row = static_cast<std::size_t>(message.width) * raw_pixel_bytes;
  const auto rows = static_cast<std::size_t>(message.height);
  const bool padded = message.row_stride > 0 && static_cast<std::size_t>(message.row_stride) > row;
  const std::size_t needed =
      padded ? static_cast<std::size_t>(message.row_stride) * (rows - 1) + row : row * rows;
  const bool has_last_padding =
      padded && message.data.size() == static_cast<std::size_t>(message.row_stride) * rows;
  if (message.data.size() != needed && !has_last_padding)
    throw DecodeError("image: " + std::to_string(message.data.size()) + " bytes, " + std::to_string(needed) +
                      " are needed");
  return {message.utime, message.width, message.height, coding,
          padded ? packed_rows(message, row) : message.data};
}

EncodedImage read_depth(const image_t& message, ImageCoding coding, std::size_t raw_pixel_bytes) {
  if (message.pixelformat == big_endian_depth)
    throw DecodeError("depth image: big-endian pixels are not supported");
  return read_image(message, coding, raw_pixel_bytes);
}

EncodedImage read_colour(const image_t& message) {
  switch (message.pixelformat) {
    case image_t::PIXEL_FORMAT_MJPEG:
      return read_image(message, ImageCoding::jpeg, 0);
    case image_t::PIXEL_FORMAT_BGR:
      return read_image(message, ImageCoding::raw_bgr, 3);
    case image_t::PIXEL_FORMAT_RGB:
      return read_image(message, ImageCoding::raw_rgb, 3);
    case image_t::PIXEL_FORMAT_GRAY:
      return read_image(message, ImageCoding::raw_gray, 1);
    default:
      throw DecodeError("pixelformat " + std::to_string(message.pixelformat) + " is not supported");
  }
}

/// Before anything is decoded: a few bytes may claim to be millions of pixels.
void check_declared_size(const char* name, const EncodedImage& image, const CameraModel& camera) {
  if (image.width != camera.width || image.height != camera.height)
    throw DecodeError(std::string("the ") + name + " image is " + std::to_string(image.width) + "x" +
                      std::to_string(image.height) + ", by its calibration it must be " +
                      std::to_string(camera.width) + "x" + std::to_string(camera.height));
}

camera_intrinsics_t intrinsics_message(const CameraModel& camera) {
  camera_intrinsics_t m;
  m.width = camera.width;
  m.height = camera.height;
  m.fx = camera.fx;
  m.fy = camera.fy;
  m.cx = camera.cx;
  m.cy = camera.cy;
  m.distortion = camera.distortion;
  m.n_distortion = static_cast<int32_t>(camera.distortion.size());
  return m;
}

CameraModel read_intrinsics(const camera_intrinsics_t& m) {
  CameraModel camera;
  camera.width = m.width;
  camera.height = m.height;
  camera.fx = m.fx;
  camera.fy = m.fy;
  camera.cx = m.cx;
  camera.cy = m.cy;
  camera.distortion = m.distortion;
  return camera;
}

constexpr std::string_view rolling_shutter_key = ";rolling_shutter=", depth_error_key = ";depth_error=",
                           depth_tilt_key = ";depth_tilt=";

std::string joined(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    char digits[32];
    text += (text.empty() ? "" : ",") +
            std::string(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr);
  }
  return text;
}

std::string sensor_text(const RgbdCalibration& c) {
  std::string text = c.sensor;
  const DepthError& e = c.depth_error;
  if (e.has_tilt()) text += std::string(depth_tilt_key) + joined({e.tilt_x, e.tilt_y});
  if (e.has_range_error())
    text += std::string(depth_error_key) + joined({e.offset, e.scale, e.wiggle, e.period, e.phase});
  if (c.rolling_shutter != 0) text += std::string(rolling_shutter_key) + joined({c.rolling_shutter});
  return text;
}

/// Cuts "KEY NUMBER,NUMBER,..." off the text's end, where it stands there.
void take_numbers(std::string& text, std::string_view key, std::initializer_list<double*> values,
                  const char* right) {
  const std::size_t begin = text.find(key);
  if (begin == std::string::npos) return;
  const char* at = text.data() + begin + key.size();
  const char* end = text.data() + text.size();
  bool good = true;
  for (double* value : values) {
    if (value != *values.begin()) good = good && at != end && *at++ == ',';
    const auto [stop, error] = std::from_chars(at, end, *value);
    good = good && error == std::errc();
    at = stop;
  }
  constexpr std::size_t longest = 80;  // bytes of it that an error repeats
  if (!good || at != end) throw DecodeError("sensor '" + printable(text.substr(0, longest)) + "': " + right);
  text.resize(begin);
}

void read_sensor_text(std::string text, RgbdCalibration& c) {
  DepthError& e = c.depth_error;
  take_numbers(text, rolling_shutter_key, {&c.rolling_shutter},
               "rolling_shutter must be a number of seconds");
  take_numbers(text, depth_error_key, {&e.offset, &e.scale, &e.wiggle, &e.period, &e.phase},
               "depth_error must be offset, scale, wiggle, period and phase");
  take_numbers(text, depth_tilt_key, {&e.tilt_x, &e.tilt_y}, "depth_tilt must be two numbers, 1/m");
  c.sensor = text;
}

/// Tables take longer to make than an image to correct. Each thread keeps those of its newest camera.
void correct_depth(cv::Mat& depth, const RgbdCalibration& calibration) {
  if (calibration.depth_error.is_zero()) return;
  struct Kept {
    CameraModel camera;
    DepthError error;
    DepthCorrector correct;
  };
  thread_local std::optional<Kept> kept;
  if (!kept || !(kept->error == calibration.depth_error) || !(kept->camera == calibration.depth))
    kept.emplace(
        Kept{calibration.depth, calibration.depth_error, {calibration.depth, calibration.depth_error}});
  kept->correct(depth);
}

}  // namespace

images_t to_message(const EncodedFrame& frame) {
  images_t message;
  message.utime = frame.utime;
  message.n_images = 0;
  switch (frame.colour.coding) {
    case ImageCoding::raw_bgr:
      add(message, images_t::LEFT, make_image(frame.colour, image_t::PIXEL_FORMAT_BGR, 3));
      break;
    case ImageCoding::raw_rgb:
      add(message, images_t::LEFT, make_image(frame.colour, image_t::PIXEL_FORMAT_RGB, 3));
      break;
    case ImageCoding::raw_gray:
      add(message, images_t::LEFT, make_image(frame.colour, image_t::PIXEL_FORMAT_GRAY, 1));
      break;
    default:
      add(message, images_t::LEFT, make_image(frame.colour, image_t::PIXEL_FORMAT_MJPEG, 0));
  }
  const bool raw = frame.depth.coding == ImageCoding::depth_raw;
  add(message, raw ? images_t::DEPTH_MM : images_t::DEPTH_MM_ZIPPED,
      make_image(frame.depth, image_t::PIXEL_FORMAT_LE_GRAY16, 2));
  if (frame.amplitude.coding != ImageCoding::none)
    add(message, images_t::AMPLITUDE_ZIPPED, make_image(frame.amplitude, image_t::PIXEL_FORMAT_GRAY, 1));
  set_text(message.images.front(), "sensor", frame.sensor);
  return message;
}

EncodedFrame from_message(const images_t& message) {
  EncodedFrame frame;
  frame.utime = message.utime;
  frame.seq = origin(message).seq;
  for (std::size_t i = 0; i < message.images.size(); ++i) {
    const image_t& image = message.images[i];
    switch (message.image_types[i]) {
      case images_t::LEFT:
        frame.colour = read_colour(image);
        frame.sensor = get_text(image, "sensor");
        break;
      case images_t::DEPTH_MM:
        frame.depth = read_depth(image, ImageCoding::depth_raw, 2);
        break;
      case images_t::DEPTH_MM_ZIPPED:
        frame.depth = read_depth(image, ImageCoding::depth_zlib, 0);
        break;
      case images_t::AMPLITUDE_ZIPPED:
        frame.amplitude = read_image(image, ImageCoding::gray_zlib, 0);
        break;
      default:
        break;  // other people's image types are none of our business
    }
  }
  if (frame.utime == 0) frame.utime = frame.colour.utime;  // drivers that stamp the images alone
  for (EncodedImage* image : {&frame.colour, &frame.depth, &frame.amplitude})
    if (image->utime == 0) image->utime = frame.utime;  // drivers that stamp the message alone
  if (frame.colour.coding == ImageCoding::none) throw DecodeError("images_t has no colour image (LEFT)");
  if (frame.depth.coding == ImageCoding::none) throw DecodeError("images_t has no depth image");
  return frame;
}

std::optional<EncodedFrame> picture_alone(const images_t& message) {
  const auto is_colour = [&](std::size_t i) { return message.image_types[i] == images_t::LEFT; };
  for (std::size_t i = 0; i < message.images.size(); ++i)  // before anything is copied
    if (!is_colour(i) && message.images[i].size > 0) return std::nullopt;
  EncodedFrame frame;
  frame.utime = message.utime;
  frame.seq = origin(message).seq;
  for (std::size_t i = 0; i < message.images.size(); ++i)
    if (is_colour(i)) frame.colour = read_colour(message.images[i]);
  if (frame.colour.coding == ImageCoding::none) return std::nullopt;
  if (frame.colour.utime == 0) frame.colour.utime = frame.utime;
  return frame;
}

EncodedFrame checked_images(const images_t& message, const RgbdCalibration& calibration) {
  constexpr Utime longest_apart = 1'000'000;  // us between the images of one shot
  EncodedFrame encoded = from_message(message);
  const Utime apart = calibration.depth_time(encoded.depth.utime) - encoded.utime;
  if (apart < -longest_apart || apart > longest_apart)
    throw DecodeError("the depth image is " + std::to_string(1e-6 * static_cast<double>(apart)) +
                      " s from the colour image: they are no shot of one moment");
  check_declared_size("colour", encoded.colour, calibration.colour);
  check_declared_size("depth", encoded.depth, calibration.depth);
  if (encoded.amplitude.coding != ImageCoding::none)
    check_declared_size("amplitude", encoded.amplitude, calibration.depth);
  return encoded;
}

RgbdFrame decode_images(const EncodedFrame& encoded, const RgbdCalibration& calibration) {
  try {
    RgbdFrame frame = decode(encoded);
    check_frame(frame, calibration);
    if (is_constant_depth(frame.depth)) frame.depth.setTo(0);
    correct_depth(frame.depth, calibration);
    return frame;
  } catch (const CodecError& error) {
    throw DecodeError(error.what());
  } catch (const std::invalid_argument& error) {
    throw DecodeError(error.what());
  }
}

RgbdFrame decode_images(const images_t& message, const RgbdCalibration& calibration) {
  return decode_images(checked_images(message, calibration), calibration);
}

camera_calibration_t to_message(const RgbdCalibration& c) {
  camera_calibration_t m;
  m.utime = 0;
  m.sensor = sensor_text(c);
  m.colour = intrinsics_message(c.colour);
  m.depth = intrinsics_message(c.depth);
  m.depth_registered = c.depth_registered;
  m.T_colour_depth = to_message(c.T_colour_depth);
  m.has_mount = c.has_mount;
  m.T_robot_camera = to_message(c.T_robot_camera);
  m.depth_clock_offset = c.depth_clock_offset;
  m.depth_noise_constant = c.depth_noise.constant;
  m.depth_noise_quadratic = c.depth_noise.quadratic;
  m.depth_noise_offset = c.depth_noise.offset;
  m.depth_noise_amplitude = c.depth_noise.amplitude;
  m.depth_min = c.depth_min;
  m.depth_max = c.depth_max;
  m.pixel_sigma = c.pixel_sigma;
  return m;
}

RgbdCalibration from_message(const camera_calibration_t& m) {
  RgbdCalibration c;
  read_sensor_text(m.sensor, c);
  c.colour = read_intrinsics(m.colour);
  c.depth = read_intrinsics(m.depth);
  c.depth_registered = m.depth_registered != 0;
  c.T_colour_depth = from_message(m.T_colour_depth, "T_colour_depth");
  c.has_mount = m.has_mount != 0;
  c.T_robot_camera = from_message(m.T_robot_camera, "T_robot_camera");
  c.depth_clock_offset = m.depth_clock_offset;
  c.depth_noise = {m.depth_noise_constant, m.depth_noise_quadratic, m.depth_noise_offset,
                   m.depth_noise_amplitude};
  c.depth_min = m.depth_min;
  c.depth_max = m.depth_max;
  c.pixel_sigma = m.pixel_sigma;
  check_range(c.depth_clock_offset, -10, 10, "depth_clock_offset");
  try {
    c.check();
  } catch (const std::invalid_argument& error) {
    throw DecodeError(error.what());
  }
  return c;
}

bool tells_rolling_shutter(const camera_calibration_t& message) {
  return message.sensor.find(rolling_shutter_key) != std::string::npos;
}

bool same_calibration(camera_calibration_t a, camera_calibration_t b) {
  for (camera_calibration_t* m : {&a, &b}) m->utime = m->seq = m->sender = 0;
  return encode_message(a) == encode_message(b);
}

bool reads_alike(RgbdCalibration a, RgbdCalibration b) {
  for (RgbdCalibration* c : {&a, &b}) {
    c->sensor.clear();
    c->has_mount = false;
    c->T_robot_camera = optical_axes();
    c->pixel_sigma = 1;
  }
  return same_calibration(to_message(a), to_message(b));
}

}  // namespace lcmslam

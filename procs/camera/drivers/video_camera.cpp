// V4L2 cameras and video files, by OpenCV's VideoCapture.

#include <cmath>
#include <opencv2/videoio.hpp>

#include <lcmslam/imaging/io/jpeg.hpp>
#include "procs/camera/drivers/image_sequence.hpp"
#include "procs/camera/drivers/open_driver.hpp"
#include "procs/camera/drivers/video_shot.hpp"
#include "procs/camera/drivers/wall_clock.hpp"

namespace lcmslam {
namespace {

constexpr double exposure_by_hand = 1, exposure_automatic = 3;  // V4L2_EXPOSURE_MANUAL, _APERTURE_PRIORITY
constexpr double exposure_unit = 100e-6;                        // s, of V4L2_CID_EXPOSURE_ABSOLUTE
// us, that a driver's stamp may be old: before it is known to be of this clock, and then (a process that got
// no processor finds old images in its buffers).
constexpr Utime longest_delay = 1'000'000, longest_sleep = 60'000'000;

class VideoCamera : public CameraDevice {
 public:
  explicit VideoCamera(const VideoSettings& settings) : settings_(settings) {}

 protected:
  CameraShot frame_of(const cv::Mat& image, Utime utime, const std::string& name) const {
    if (!jpeg_) return video_shot(image, utime, settings_, name);
    CameraShot frame;
    frame.utime = frame.depth_utime = utime;
    keep(image, frame);
    return frame;
  }

  std::string size_and_rate(double rate) const {
    char text[64];
    std::snprintf(text, sizeof text, "%.0fx%.0f, %g Hz", capture_.get(cv::CAP_PROP_FRAME_WIDTH),
                  capture_.get(cv::CAP_PROP_FRAME_HEIGHT), rate);
    return text;
  }
  double own_rate() const { return capture_.get(cv::CAP_PROP_FPS); }
  /// Four letters.
  std::string format() const {
    const auto code = static_cast<std::uint32_t>(capture_.get(cv::CAP_PROP_FOURCC));
    std::string text;
    for (int i = 0; i < 4; ++i) text += static_cast<char>(code >> (8 * i) & 0xff);
    return text;
  }
  /// Images come as JPEG and are to stay so.
  bool keeps_jpeg() const {
    return settings_.keep_jpeg && settings_.images == "colour" && format() == "MJPG";
  }

  VideoSettings settings_;
  cv::VideoCapture capture_;
  bool jpeg_ = false;  // capture_ gives bytes

 private:
  static void keep(const cv::Mat& bytes, CameraShot& frame) {
    try {
      if (bytes.depth() != CV_8U || !bytes.isContinuous()) throw CodecError("no bytes of a JPEG");
      const std::size_t size = jpeg_bytes(bytes.data, bytes.total() * bytes.elemSize());
      frame.jpeg.assign(bytes.data, bytes.data + size);
      const ImageSize declared = jpeg_size(frame.jpeg);
      frame.jpeg_size = {declared.width, declared.height};
    } catch (const CodecError& error) {
      frame.jpeg.clear();
      frame.damage = error.what();
    }
  }
};

/// A video.
class VideoFile : public VideoCamera {
 public:
  explicit VideoFile(const VideoSettings& settings)
      : VideoCamera(settings), start_(start_utime(settings.start)) {
    if (!capture_.open(settings.file, cv::CAP_FFMPEG) && !capture_.open(settings.file))
      throw CameraError(settings.file + ": cannot be opened, or is no video that OpenCV reads");
    jpeg_ = keeps_jpeg() &&
            bytes_.open(settings.file, cv::CAP_FFMPEG, {cv::CAP_PROP_FORMAT, -1});  // as they are in the file
  }

  std::optional<CameraShot> read(std::chrono::milliseconds) override {
    cv::Mat image;
    const bool more = jpeg_ ? capture_.grab() && next_bytes(image) : !ended_ && capture_.read(image);
    if (ended_ || !more) {
      ended_ = true;
      return std::nullopt;
    }
    return frame_of(image, start_ + since_start(), settings_.file);
  }

  bool ended() const override { return ended_; }
  std::string describe() const override {
    return settings_.file + ": " + size_and_rate(own_rate()) + (jpeg_ ? ", MJPG as it is" : "");
  }

 private:
  /// Where an image was left out some containers have a packet without bytes; decoded there is no image.
  bool next_bytes(cv::Mat& bytes) {
    while (bytes_.read(bytes))
      if (!bytes.empty()) return true;
    return false;
  }

  Utime since_start() const {  // us
    return static_cast<Utime>(std::llround(capture_.get(cv::CAP_PROP_POS_MSEC) * 1000));
  }

  cv::VideoCapture bytes_;  // the same file, undecoded: has no stamps, which capture_ knows
  Utime start_;
  bool ended_ = false;
};

/// A V4L2 camera.
class VideoDevice : public VideoCamera {
 public:
  explicit VideoDevice(const VideoSettings& settings) : VideoCamera(settings) {
    if (!capture_.open(settings.device, cv::CAP_V4L2))
      throw CameraError(settings.device +
                        ": no V4L2 camera, or it cannot be opened (is it plugged in, is another " +
                        "program using it, may this user: group video?)");
    if (!settings.format.empty()) {
      const std::string& f = settings.format;
      capture_.set(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc(f[0], f[1], f[2], f[3]));
    }
    jpeg_ = keeps_jpeg();
    if (settings.images == "depth" || jpeg_) capture_.set(cv::CAP_PROP_CONVERT_RGB, 0);
    if (settings.width > 0) capture_.set(cv::CAP_PROP_FRAME_WIDTH, settings.width);
    if (settings.height > 0) capture_.set(cv::CAP_PROP_FRAME_HEIGHT, settings.height);
    if (settings.rate > 0) capture_.set(cv::CAP_PROP_FPS, settings.rate);
    const bool by_hand = settings.exposure > 0;
    capture_.set(cv::CAP_PROP_AUTO_EXPOSURE, by_hand ? exposure_by_hand : exposure_automatic);
    if (by_hand && !capture_.set(cv::CAP_PROP_EXPOSURE, std::round(settings.exposure / exposure_unit)))
      notes_ += ", takes no exposure";
    if (!settings.format.empty() && format() != settings.format) notes_ += " instead of " + settings.format;
  }

  std::optional<CameraShot> read(std::chrono::milliseconds patience) override {
    std::vector<int> ready;
    try {
      if (!cv::VideoCapture::waitAny({capture_}, ready, std::chrono::nanoseconds(patience).count()))
        return std::nullopt;
    } catch (const cv::Exception& error) {
      throw CameraError(settings_.device + ": is gone: " + error.err);
    }
    const Utime arrival = wall_clock();
    cv::Mat image;
    // A JPEG without a byte is a damaged image like others, and no camera that is gone.
    if (!capture_.grab() || !capture_.retrieve(image) || (image.empty() && !jpeg_))
      throw CameraError(settings_.device + ": is gone: it gives no more images");
    return frame_of(image, stamp(arrival), settings_.device);
  }

  std::string describe() const override {
    return settings_.device + ": " + size_and_rate(own_rate()) + ", " + format() +
           (jpeg_ ? " as it is" : "") + notes_;
  }

 private:
  /// V4L2 drivers stamp by the monotonic clock; one that does not is stamped at its arrival. Both clocks are
  /// read at once: decoding took its time since the arrival.
  Utime stamp(Utime arrival) {
    const auto taken = static_cast<Utime>(capture_.get(cv::CAP_PROP_POS_MSEC) * 1000);
    const HostTime now = host_time();
    const Utime age = now.steady - taken;
    if (age < 0 || age > (known_clock_ ? longest_sleep : longest_delay)) return arrival;
    known_clock_ = true;
    return clock_.to_host(taken, {now.wall - age, taken});
  }

  std::string notes_;
  bool known_clock_ = false;  // the driver's stamps are of the monotonic clock
  DeviceClock clock_;         // that clock, of which nothing but the wall clock's settings must be followed
};

}  // namespace

std::unique_ptr<CameraDevice> open_video(const VideoSettings& settings) {
  if (settings.file.find('%') != std::string::npos) return open_sequence(settings);
  if (!settings.file.empty()) return std::make_unique<VideoFile>(settings);
  return std::make_unique<VideoDevice>(settings);
}

}  // namespace lcmslam

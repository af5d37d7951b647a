// The first Kinect, by libfreenect.

#include <libfreenect.h>
#include <opencv2/imgproc.hpp>

#include <array>
#include <cmath>
#include <deque>

#include <lcmslam/cameras/device_clock.hpp>
#include <lcmslam/cameras/image_pairs.hpp>
#include "procs/camera/drivers/open_driver.hpp"
#include "procs/camera/drivers/wall_clock.hpp"

namespace lcmslam {

const bool has_freenect = true;

namespace {

constexpr int ticks_a_microsecond = 60;                  // of the Kinect's clock
constexpr Utime pair_tolerance = 1'000'000 / 60;         // us: half an interval
constexpr double least_depth = 0.3, largest_depth = 10;  // m, of the formula below

/// Raw disparities of 11 bits (0 to 2047) as millimetres, by the fit that Kinects have in common (Burrus
/// 2010): 1 / z = 3.3309495161 - 0.0030711016 d.
const std::array<std::uint16_t, 2048>& depth_of_disparity() {
  static const auto table = [] {
    std::array<std::uint16_t, 2048> t{};
    for (std::size_t d = 0; d < t.size(); ++d) {
      const double z = 1 / (3.3309495161 - 0.0030711016 * static_cast<double>(d));
      if (z >= least_depth && z <= largest_depth) t[d] = static_cast<std::uint16_t>(std::lround(1000 * z));
    }
    return t;
  }();
  return table;
}

/// The mode of a format among those that the library offers; an invalid one when it lacks it.
template <class Mode>
freenect_frame_mode find_mode(int count, freenect_frame_mode (*mode)(int), const Mode& fits) {
  for (int i = 0; i < count; ++i) {
    const freenect_frame_mode m = mode(i);
    if (m.is_valid && m.resolution == FREENECT_RESOLUTION_MEDIUM && fits(m)) return m;
  }
  return {};
}

class FreenectCamera : public CameraDevice {
 public:
  FreenectCamera(const FreenectSettings& settings, const WantedImages& wanted)
      : wanted_(wanted),
        name_(settings.serial.empty() ? "Kinect" : "Kinect " + settings.serial),
        pairs_(pair_tolerance, wanted.depth_offset) {
    if (freenect_init(&context_, nullptr) < 0)
      throw CameraError(name_ + ": libfreenect does not start (USB)");
    try {
      open(settings);
    } catch (const CameraError&) {
      close();
      throw;
    }
  }
  ~FreenectCamera() override { close(); }

  std::optional<CameraShot> read(std::chrono::milliseconds patience) override {
    const auto end = std::chrono::steady_clock::now() + patience;
    do {
      if (auto frame = take()) return frame;
      timeval wait{0, 20'000};
      if (freenect_process_events_timeout(context_, &wait) < 0)
        throw CameraError(name_ + ": has been unplugged");
    } while (std::chrono::steady_clock::now() < end);
    return take();
  }

  std::string describe() const override {
    return name_ + ": 640x480, 30 Hz, depth " + depth_name() +
           (clock_.believed() ? "" : ", stamped at arrival: its own stamps are no ticks of 60 MHz");
  }

 private:
  void open(const FreenectSettings& settings) {
    freenect_set_log_level(context_, FREENECT_LOG_ERROR);
    freenect_select_subdevices(context_, FREENECT_DEVICE_CAMERA);
    if (freenect_num_devices(context_) < 1) throw CameraError(name_ + ": none is plugged in");
    const int status = settings.serial.empty() ? freenect_open_device(context_, &device_, 0)
                                               : freenect_open_device_by_camera_serial(
                                                     context_, &device_, settings.serial.c_str());
    if (status < 0)
      throw CameraError(name_ + ": cannot be opened (is its power supply in, may this user: group plugdev?)");
    freenect_set_user(device_, this);
    if (wanted_.colour) start_colour();
    if (wanted_.depth) start_depth();
  }

  void close() {
    if (device_ != nullptr) {
      if (wanted_.colour) freenect_stop_video(device_);
      if (wanted_.depth) freenect_stop_depth(device_);
      freenect_close_device(device_);
    }
    freenect_shutdown(context_);
  }

  void start_colour() {
    const auto mode = find_mode(freenect_get_video_mode_count(), freenect_get_video_mode,
                                [](const auto& m) { return m.video_format == FREENECT_VIDEO_RGB; });
    colour_.create(480, 640, CV_8UC3);
    freenect_set_video_callback(device_, [](freenect_device* device, void*, std::uint32_t ticks) {
      static_cast<FreenectCamera*>(freenect_get_user(device))->on_colour(ticks);
    });
    if (!mode.is_valid || freenect_set_video_mode(device_, mode) < 0 ||
        freenect_set_video_buffer(device_, colour_.data) < 0 || freenect_start_video(device_) < 0)
      throw CameraError(name_ + ": gives no colour images");
  }

  /// Millimetres, registered to colour or not; else raw disparities, which is all that older libraries and
  /// recordings have.
  void start_depth() {
    const auto find = [](freenect_depth_format format) {
      return find_mode(freenect_get_depth_mode_count(), freenect_get_depth_mode,
                       [&](const auto& m) { return m.depth_format == format; });
    };
    auto mode = find(wanted_.registered ? FREENECT_DEPTH_REGISTERED : FREENECT_DEPTH_MM);
    if (!mode.is_valid && wanted_.registered)
      throw CameraError(name_ +
                        ": gives no depth registered to colour, as its calibration says (depth_registered)");
    if (!mode.is_valid) mode = find(FREENECT_DEPTH_11BIT);
    format_ = mode.depth_format;
    depth_.create(480, 640, CV_16UC1);
    freenect_set_depth_callback(device_, [](freenect_device* device, void*, std::uint32_t ticks) {
      static_cast<FreenectCamera*>(freenect_get_user(device))->on_depth(ticks);
    });
    if (!mode.is_valid || freenect_set_depth_mode(device_, mode) < 0 ||
        freenect_set_depth_buffer(device_, depth_.data) < 0 || freenect_start_depth(device_) < 0)
      throw CameraError(name_ + ": gives no depth images");
  }

  const char* depth_name() const {
    return format_ == FREENECT_DEPTH_REGISTERED ? "registered"
           : format_ == FREENECT_DEPTH_MM       ? "in millimetres"
                                                : "from disparities";
  }

  Utime stamp(std::uint32_t ticks) {
    return clock_.to_host(unroll_(ticks) / ticks_a_microsecond, host_time());
  }

  void on_colour(std::uint32_t ticks) {
    CameraShot frame;
    frame.utime = frame.depth_utime = stamp(ticks);
    cv::cvtColor(colour_, frame.colour, cv::COLOR_RGB2BGR);
    give(std::move(frame));
  }

  void on_depth(std::uint32_t ticks) {
    CameraShot frame;
    frame.utime = frame.depth_utime = stamp(ticks);
    frame.depth = depth_.clone();
    if (format_ == FREENECT_DEPTH_11BIT)
      frame.depth.forEach<std::uint16_t>(
          [](std::uint16_t& value, const int*) { value = value < 2048 ? depth_of_disparity()[value] : 0; });
    give(std::move(frame));
  }

  void give(CameraShot frame) {
    if (!wanted_.colour || !wanted_.depth)
      single_.push_back(std::move(frame));
    else if (frame.colour.empty())
      pairs_.add_depth(std::move(frame));
    else
      pairs_.add_colour(std::move(frame));
  }

  std::optional<CameraShot> take() {
    if (single_.empty()) return pairs_.next();
    CameraShot frame = std::move(single_.front());
    single_.pop_front();
    return frame;
  }

  WantedImages wanted_;
  std::string name_;
  freenect_context* context_ = nullptr;
  freenect_device* device_ = nullptr;
  freenect_depth_format format_ = FREENECT_DEPTH_MM;
  cv::Mat colour_, depth_;  // that libfreenect writes
  UnrolledCounter unroll_;  // both cameras have one clock
  DeviceClock clock_;
  ImagePairs pairs_;
  std::deque<CameraShot> single_;
};

}  // namespace

std::unique_ptr<CameraDevice> open_freenect(const FreenectSettings& settings, const WantedImages& wanted) {
  return std::make_unique<FreenectCamera>(settings, wanted);
}

}  // namespace lcmslam

// Xtion and PrimeSense cameras, and .oni files, by OpenNI2.

#include <OpenNI.h>
#include <atomic>
#include <opencv2/imgproc.hpp>
#include <set>

#include <lcmslam/cameras/device_clock.hpp>
#include <lcmslam/cameras/image_pairs.hpp>
#include "procs/camera/drivers/open_driver.hpp"
#include "procs/camera/drivers/wall_clock.hpp"

namespace lcmslam {

const bool has_openni2 = true;

namespace {

constexpr int file_patience = 1000;  // ms, that the reader of a file may take

std::string openni_error() {
  std::string text = openni::OpenNI::getExtendedError();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\t')) text.pop_back();
  text.erase(0, text.find_first_not_of("\t\n "));
  return text.empty() ? "OpenNI2 does not say why" : text;
}

/// The cameras that are there: who writes a URI finds it nowhere else, and it changes with each plugging in.
std::string uris_there() {
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  std::string uris;
  for (int i = 0; i < devices.getSize(); ++i) uris += (i > 0 ? ", " : "") + std::string(devices[i].getUri());
  return uris.empty() ? "no camera is there" : "there are: " + uris;
}

/// Once, for the life of the process: OpenNI2 loads its drivers.
void initialise() {
  static const openni::Status status = openni::OpenNI::initialize();
  if (status != openni::STATUS_OK) throw CameraError("OpenNI2 does not start: " + openni_error());
}

cv::Mat view(const openni::VideoFrameRef& frame, int type) {
  const auto needed = static_cast<long>(frame.getStrideInBytes()) * frame.getHeight();
  if (frame.getWidth() <= 0 || frame.getHeight() <= 0 || frame.getDataSize() < needed ||
      frame.getStrideInBytes() < frame.getWidth() * static_cast<int>(CV_ELEM_SIZE(type)))
    throw CameraError("an image has fewer bytes than its size needs");
  return {frame.getHeight(), frame.getWidth(), type, const_cast<void*>(frame.getData()),
          static_cast<std::size_t>(frame.getStrideInBytes())};
}

cv::Mat colour_of(const openni::VideoFrameRef& frame) {
  cv::Mat bgr;
  switch (frame.getVideoMode().getPixelFormat()) {
    case openni::PIXEL_FORMAT_RGB888:
      cv::cvtColor(view(frame, CV_8UC3), bgr, cv::COLOR_RGB2BGR);
      break;
    case openni::PIXEL_FORMAT_YUV422:
      cv::cvtColor(view(frame, CV_8UC2), bgr, cv::COLOR_YUV2BGR_UYVY);
      break;
    case openni::PIXEL_FORMAT_YUYV:
      cv::cvtColor(view(frame, CV_8UC2), bgr, cv::COLOR_YUV2BGR_YUYV);
      break;
    case openni::PIXEL_FORMAT_GRAY8:
      cv::cvtColor(view(frame, CV_8UC1), bgr, cv::COLOR_GRAY2BGR);
      break;
    default:
      throw CameraError("the colour images' format is not known");
  }
  return bgr;
}

cv::Mat depth_of(const openni::VideoFrameRef& frame) {
  cv::Mat depth;
  switch (frame.getVideoMode().getPixelFormat()) {
    case openni::PIXEL_FORMAT_DEPTH_1_MM:
      depth = view(frame, CV_16UC1).clone();
      break;
    case openni::PIXEL_FORMAT_DEPTH_100_UM:
      view(frame, CV_16UC1).convertTo(depth, CV_16UC1, 0.1);
      break;
    default:
      throw CameraError("the depth images' format is not millimetres");
  }
  return depth;
}

/// A device and its streams, closed in the order that OpenNI2 needs. Those of a file stay open to the
/// process's end (so it can be read but once): the thread of OpenNI2 2.2 that plays it looks at its streams
/// without a lock while they are taken away.
class Opened {
 public:
  explicit Opened(bool recorded) : recorded_(recorded), parts_(std::make_unique<Parts>()) {}
  ~Opened() {
    for (openni::VideoStream* stream : streams) stream->stop();
    if (recorded_) static_cast<void>(parts_.release());
  }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  openni::Device& device() { return parts_->device; }
  const openni::Device& device() const { return parts_->device; }
  openni::VideoStream& colour() { return parts_->colour; }
  openni::VideoStream& depth() { return parts_->depth; }
  std::vector<openni::VideoStream*> streams;  // those that are used

 private:
  struct Parts {
    openni::Device device;
    openni::VideoStream colour, depth;  // destroyed before the device
  };
  bool recorded_;
  std::unique_ptr<Parts> parts_;
};

class OpenNi2Camera : public CameraDevice, private openni::OpenNI::DeviceDisconnectedListener {
 public:
  OpenNi2Camera(const OpenNi2Settings& settings, const WantedImages& wanted)
      : settings_(settings),
        recorded_(!settings.file.empty()),
        name_(recorded_                 ? settings.file
              : settings.device.empty() ? "OpenNI2"
                                        : settings.device),
        opened_(recorded_),
        pairs_(static_cast<Utime>(0.5e6 / settings.rate), wanted.depth_offset) {
    initialise();
    const bool is_named = !recorded_ && !settings.device.empty();
    const char* uri = recorded_ ? settings.file.c_str() : settings.device.c_str();
    if (opened_.device().open(*uri == '\0' ? openni::ANY_DEVICE : uri) != openni::STATUS_OK)
      throw CameraError(name_ + ": " + openni_error() + (is_named ? " (" + uris_there() + ")" : ""));
    if (wanted.colour) add_stream(opened_.colour(), openni::SENSOR_COLOR, "colour");
    if (wanted.depth) add_stream(opened_.depth(), openni::SENSOR_DEPTH, "depth");
    if (recorded_)
      prepare_file();
    else
      prepare_camera(wanted);
    for (openni::VideoStream* stream : opened_.streams)
      if (stream->getMirroringEnabled()) mirrored_.insert(stream);
    for (openni::VideoStream* stream : opened_.streams)
      if (stream->start() != openni::STATUS_OK) throw CameraError(name_ + ": " + openni_error());
    openni::OpenNI::addDeviceDisconnectedListener(this);
  }

  ~OpenNi2Camera() override { openni::OpenNI::removeDeviceDisconnectedListener(this); }

  std::optional<CameraShot> read(std::chrono::milliseconds patience) override {
    if (opened_.streams.size() == 1) return read_image(patience);
    if (auto pair = pairs_.next()) return pair;
    // Where one stream has died the other goes on, and no pair ever comes.
    const auto end = std::chrono::steady_clock::now() + patience;
    while (const auto image = read_image(patience)) {
      image->colour.empty() ? pairs_.add_depth(*image) : pairs_.add_colour(*image);
      if (auto pair = pairs_.next()) return pair;
      if (!recorded_ && std::chrono::steady_clock::now() > end) break;
    }
    if (ended_) pairs_.finish();
    return pairs_.next();
  }

  bool ended() const override { return ended_; }

  std::string describe() const override {
    const openni::VideoMode mode = opened_.streams.front()->getVideoMode();
    return name_ + ": " + opened_.device().getDeviceInfo().getVendor() + " " +
           opened_.device().getDeviceInfo().getName() + ", " + std::to_string(mode.getResolutionX()) + "x" +
           std::to_string(mode.getResolutionY()) + ", " + std::to_string(mode.getFps()) + " Hz" +
           (mirrored_.empty() ? "" : ", mirrored: its images are turned over") +
           (clock_.believed() ? "" : ", stamped at arrival: its own stamps are no microseconds");
  }

 private:
  void add_stream(openni::VideoStream& stream, openni::SensorType sensor, const char* name) {
    if (!opened_.device().hasSensor(sensor) || stream.create(opened_.device(), sensor) != openni::STATUS_OK)
      throw CameraError(name_ + ": has no " + name + " images: " + openni_error());
    opened_.streams.push_back(&stream);
  }

  /// Reading asks for the next image: nothing is lost, however slow the reader.
  void prepare_file() {
    openni::PlaybackControl* playback = opened_.device().getPlaybackControl();
    if (playback == nullptr) throw CameraError(name_ + ": is no recording");
    playback->setRepeatEnabled(false);
    playback->setSpeed(-1);
    for (openni::VideoStream* stream : opened_.streams) left_ += playback->getNumberOfFrames(*stream);
    start_ = start_utime(settings_.start);
  }

  void prepare_camera(const WantedImages& wanted) {
    for (openni::VideoStream* stream : opened_.streams) {
      openni::VideoMode mode = stream->getVideoMode();
      mode.setResolution(settings_.width, settings_.height);
      mode.setFps(static_cast<int>(settings_.rate));
      stream->setVideoMode(mode);  // where it is refused the images' size tells
      stream->setMirroringEnabled(false);
    }
    if (opened_.streams.size() < 2) return;
    opened_.device().setDepthColorSyncEnabled(true);
    const auto registration =
        wanted.registered ? openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR : openni::IMAGE_REGISTRATION_OFF;
    if (opened_.device().setImageRegistrationMode(registration) != openni::STATUS_OK && wanted.registered)
      throw CameraError(name_ +
                        ": does not register depth to colour, as its calibration says (depth_registered)");
  }

  /// One image of either camera.
  std::optional<CameraShot> read_image(std::chrono::milliseconds patience) {
    if (gone_) throw CameraError(name_ + ": has been unplugged");
    if (recorded_ && left_ == 0) {
      ended_ = true;
      return std::nullopt;
    }
    int index = -1;
    const int wait = recorded_ ? file_patience : static_cast<int>(patience.count());
    const auto status = openni::OpenNI::waitForAnyStream(
        opened_.streams.data(), static_cast<int>(opened_.streams.size()), &index, wait);
    if (status == openni::STATUS_TIME_OUT) {
      ended_ = recorded_;
      return std::nullopt;
    }
    openni::VideoFrameRef image;
    openni::VideoStream* stream = index >= 0 ? opened_.streams[static_cast<std::size_t>(index)] : nullptr;
    if (status != openni::STATUS_OK || stream == nullptr || stream->readFrame(&image) != openni::STATUS_OK)
      throw CameraError(name_ + ": " + openni_error());
    --left_;
    return frame_of(image, stream);
  }

  CameraShot frame_of(const openni::VideoFrameRef& image, const openni::VideoStream* stream) {
    CameraShot frame;
    const auto device_time = static_cast<Utime>(image.getTimestamp());
    frame.utime = frame.depth_utime =
        recorded_ ? start_ + device_time : clock_.to_host(device_time, host_time());
    const bool is_depth = stream == &opened_.depth();
    cv::Mat& pixels = is_depth ? frame.depth : frame.colour;
    try {
      pixels = is_depth ? depth_of(image) : colour_of(image);
      if (mirrored_.count(stream) > 0) cv::flip(pixels, pixels, 1);
    } catch (const CameraError& error) {
      throw CameraError(name_ + ": " + error.what());
    }
    return frame;
  }

  void onDeviceDisconnected(const openni::DeviceInfo* info) override {
    if (info != nullptr && std::string(info->getUri()) == opened_.device().getDeviceInfo().getUri())
      gone_ = true;
  }

  OpenNi2Settings settings_;
  bool recorded_;
  std::string name_;
  Opened opened_;
  std::set<const openni::VideoStream*> mirrored_;  // a recording stays so, whatever is asked for
  ImagePairs pairs_;
  DeviceClock clock_;  // both cameras have one
  Utime start_ = 0;
  long left_ = 0;  // images of a file that have not been read
  bool ended_ = false;
  std::atomic<bool> gone_{false};
};

}  // namespace

std::unique_ptr<CameraDevice> open_openni2(const OpenNi2Settings& settings, const WantedImages& wanted) {
  return std::make_unique<OpenNi2Camera>(settings, wanted);
}

}  // namespace lcmslam

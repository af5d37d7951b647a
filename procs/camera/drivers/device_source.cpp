// Cameras, or recordings in their place.

#include "procs/camera/drivers/device_source.hpp"

#include <lcmslam/cameras/paired_recording.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include "procs/camera/drivers/open_driver.hpp"
#include "procs/camera/drivers/wall_clock.hpp"
#include "procs/camera/encode_shot.hpp"
#include "procs/camera/live_source.hpp"

namespace lcmslam {
namespace {

/// A recording is played like a data set: at its pace, to its end.
class RecordedSource : public CameraSource {
 public:
  RecordedSource(const RgbdCalibration& calibration, const ExpectedImages& expected,
                 std::unique_ptr<CameraDevice> device, int jpeg_quality)
      : calibration_(calibration),
        expected_(expected),
        device_(std::move(device)),
        jpeg_quality_(jpeg_quality) {}

  const RgbdCalibration& calibration() const override { return calibration_; }
  std::size_t frames() const override { return 0; }
  std::size_t malformed() const override { return malformed_; }
  std::vector<std::string> notes() const override { return {device_->describe()}; }
  std::vector<std::string> warnings() const override {
    if (malformed_ == 0) return {};
    return {std::to_string(malformed_) + " times, first: " + first_misfit_};
  }

  std::optional<CameraEvent> next() override {
    while (true) {
      auto frame = device_->read(std::chrono::milliseconds(1000));
      if (!frame && device_->ended()) return std::nullopt;
      if (!frame) continue;
      const std::string wrong = misfit(*frame, expected_);
      if (wrong.empty()) return encode_shot(std::move(*frame), calibration_, jpeg_quality_);
      if (malformed_++ == 0) first_misfit_ = wrong;
    }
  }

 private:
  RgbdCalibration calibration_;
  ExpectedImages expected_;
  std::unique_ptr<CameraDevice> device_;
  int jpeg_quality_;
  std::size_t malformed_ = 0;
  std::string first_misfit_;
};

cv::Size size_of(const CameraModel& camera) {
  return {camera.width, camera.height};
}

/// What the only camera must give: a driver of `video` has but one kind of images.
ExpectedImages expected_of(const DriverSettings& driver, const RgbdCalibration& calibration) {
  ExpectedImages both{size_of(calibration.colour), size_of(calibration.depth)};
  if (driver.driver != "video") return both;
  return driver.video.images == "depth" ? ExpectedImages{{}, both.depth} : ExpectedImages{both.colour, {}};
}

/// A V4L2 camera is asked for the size that it must have, unless another is named. OpenCV would ask for
/// 640x480.
DriverSettings of_size(DriverSettings driver, const ExpectedImages& expected) {
  VideoSettings& video = driver.video;
  const cv::Size size = video.images == "depth" ? expected.depth : expected.colour;
  if (video.width == 0) video.width = size.width, video.height = size.height;
  return driver;
}

std::unique_ptr<CameraSource> make_single(const DriverSettings& driver, const RgbdCalibration& calibration,
                                          const LiveSettings& live) {
  const WantedImages wanted{true, true, calibration.depth_registered, calibration.depth_offset()};
  const ExpectedImages expected = expected_of(driver, calibration);
  if (driver.is_recording())
    return std::make_unique<RecordedSource>(calibration, expected, open_driver(driver, wanted),
                                            live.jpeg_quality);
  const DriverSettings sized = of_size(driver, expected);
  std::vector<WatchedPart> parts = {{"", [=] { return open_driver(sized, wanted); }, expected}};
  return std::make_unique<LiveSource>(calibration, std::move(parts), 0, live);
}

/// Opened one after the other they are nevertheless of one moment.
void begin_together(DriverSettings& colour, DriverSettings& depth) {
  double &one = colour.start(), &other = depth.start();
  if ((one > 0) != (other > 0))
    throw CameraError(std::string("camera.pair: ") + (one > 0 ? "depth" : "colour") +
                      ".start is missing; two recordings must both have one, or none");
  if (!(one > 0)) one = other = 1e-6 * static_cast<double>(wall_clock());
}

std::unique_ptr<CameraSource> make_pair_source(const PairSourceSettings& pair,
                                               const RgbdCalibration& calibration, const LiveSettings& live) {
  if (calibration.depth_registered)
    throw CameraError(live.calibration.string() +
                      ": depth_registered must be false: nobody registers the images of two cameras");
  DriverSettings colour = pair.colour, depth = pair.depth;
  if (colour.is_recording() != depth.is_recording())
    throw CameraError("camera.pair: must be two cameras or two recordings, not one of each");
  const WantedImages colour_alone{true, false}, depth_alone{false, true};
  const ExpectedImages expected{size_of(calibration.colour), size_of(calibration.depth)};
  const auto tolerance = static_cast<Utime>(1e6 * pair.tolerance);
  if (colour.is_recording()) {
    begin_together(colour, depth);
    return std::make_unique<RecordedSource>(
        calibration, expected,
        std::make_unique<PairedRecording>(open_driver(colour, colour_alone), open_driver(depth, depth_alone),
                                          ImagePairs(tolerance, calibration.depth_offset())),
        live.jpeg_quality);
  }
  colour = of_size(colour, expected), depth = of_size(depth, expected);
  std::vector<WatchedPart> parts = {
      {"colour", [=] { return open_driver(colour, colour_alone); }, {expected.colour, {}}},
      {"depth", [=] { return open_driver(depth, depth_alone); }, {{}, expected.depth}}};
  return std::make_unique<LiveSource>(calibration, std::move(parts), tolerance, live);
}

std::unique_ptr<CameraSource> make_device_source(const CameraSettings& settings) {
  const RgbdCalibration calibration = load_calibration(settings.live.calibration);
  if (settings.source == "pair") {
    for (const DriverSettings* driver : {&settings.pair.colour, &settings.pair.depth})
      require_driver(driver->driver);
    return make_pair_source(settings.pair, calibration, settings.live);
  }
  require_driver(settings.source);
  const DriverSettings driver{settings.source, settings.video, settings.openni2, settings.freenect};
  return make_single(driver, calibration, settings.live);
}

}  // namespace

std::unique_ptr<CameraSource> make_source_or_device(const CameraSettings& settings) {
  return settings.is_device() ? make_device_source(settings) : make_camera_source(settings);
}

}  // namespace lcmslam

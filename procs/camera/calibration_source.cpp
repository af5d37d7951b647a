#include <lcmslam/imaging/io/calibration_file.hpp>
#include "procs/camera/camera_source.hpp"

namespace lcmslam {
namespace {

class CalibrationSource : public CameraSource {
 public:
  explicit CalibrationSource(const std::filesystem::path& file)
      : file_(file.string()), calibration_(load_calibration(file)) {}

  const RgbdCalibration& calibration() const override { return calibration_; }
  std::optional<CameraEvent> next() override { return std::nullopt; }
  std::size_t frames() const override { return 0; }
  bool calibrates_only() const override { return true; }
  std::vector<std::string> notes() const override {
    return {file_ + ": " + describe(calibration_) + "; images come from another driver's CAMERA"};
  }

 private:
  std::string file_;
  RgbdCalibration calibration_;
};

/// The same, and the images come from a channel of another name.
class ChannelSource : public CalibrationSource {
 public:
  ChannelSource(const ChannelSourceSettings& settings, const LiveSettings& live)
      : CalibrationSource(live.calibration), channel_(settings.channel) {}

  bool calibrates_only() const override { return false; }
  std::string relays() const override { return channel_; }
  std::vector<std::string> notes() const override {
    return {describe(calibration()) + "; images come from another driver's " + channel_};
  }

 private:
  std::string channel_;
};

}  // namespace

std::unique_ptr<CameraSource> make_channel_source(const ChannelSourceSettings& settings,
                                                  const LiveSettings& live) {
  return std::make_unique<ChannelSource>(settings, live);
}

std::unique_ptr<CameraSource> make_calibration_source(const CalibrationSourceSettings& settings) {
  return std::make_unique<CalibrationSource>(settings.file);
}

}  // namespace lcmslam

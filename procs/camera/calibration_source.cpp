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

}  // namespace

std::unique_ptr<CameraSource> make_calibration_source(const CalibrationSourceSettings& settings) {
  return std::make_unique<CalibrationSource>(settings.file);
}

}  // namespace lcmslam

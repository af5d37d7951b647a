#include "procs/camera/drivers/image_sequence.hpp"

#include <spdlog/spdlog.h>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include <lcmslam/datasets/numbered_files.hpp>
#include "procs/camera/drivers/video_shot.hpp"
#include "procs/camera/drivers/wall_clock.hpp"

namespace lcmslam {
namespace {

constexpr double usual_rate = 30;  // Hz, where nobody says

class ImageSequence : public CameraDevice {
 public:
  explicit ImageSequence(const VideoSettings& settings)
      : settings_(settings), files_("", settings.file), start_(start_utime(settings.start)) {
    const bool is_pattern = NumberedFiles::is_pattern(settings.file);
    if (is_pattern) ahead_ = next_image();
    if (ahead_.empty())
      throw CameraError(settings.file + ": cannot be opened, or is no sequence of images" +
                        (is_pattern ? "" : ": their number's place is %d or %06d, in the name"));
    size_ = ahead_.size();
    tell_what_is_missing();
  }

  std::optional<CameraShot> read(std::chrono::milliseconds) override {
    if (ended()) return std::nullopt;
    const auto since_first = static_cast<double>(number_ - files_.numbers().front());
    const Utime utime = start_ + static_cast<Utime>(std::llround(1e6 / rate() * since_first));
    CameraShot shot = video_shot(ahead_, utime, settings_, settings_.file);
    ahead_ = next_image();
    return shot;
  }

  bool ended() const override { return ahead_.empty(); }
  std::string describe() const override {
    return fmt::format("{}: {}x{}, {:g} Hz", settings_.file, size_.width, size_.height, rate());
  }

 private:
  double rate() const { return settings_.rate > 0 ? settings_.rate : usual_rate; }

  void tell_what_is_missing() const {
    const std::vector<long>& numbers = files_.numbers();
    const long all = numbers.back() - numbers.front() + 1, there = static_cast<long>(numbers.size());
    if (there == all) return;
    long first = numbers.front();
    while (files_.has(first)) ++first;
    spdlog::warn("{}: missing are {} of {} images, the first {}; it goes on after each gap", settings_.file,
                 all - there, all, files_.path(first).filename().string());
  }

  /// Empty at the end.
  cv::Mat next_image() {
    while (next_ < files_.numbers().size()) {
      number_ = files_.numbers()[next_++];
      cv::Mat image = cv::imread(files_.path(number_).string(), cv::IMREAD_UNCHANGED);
      if (!image.empty()) return image;
      if (!std::exchange(told_, true))
        spdlog::warn("{}: is no image that can be read, and is left out like others after it",
                     files_.path(number_).string());
    }
    return {};
  }

  VideoSettings settings_;
  NumberedFiles files_;
  Utime start_;
  std::size_t next_ = 0;  // of the numbers that exist
  long number_ = 0;       // of the image ahead
  cv::Mat ahead_;
  cv::Size size_;
  bool told_ = false;
};

}  // namespace

std::unique_ptr<CameraDevice> open_sequence(const VideoSettings& settings) {
  return std::make_unique<ImageSequence>(settings);
}

}  // namespace lcmslam

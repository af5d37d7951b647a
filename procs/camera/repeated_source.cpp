#include "procs/camera/repeated_source.hpp"

#include <algorithm>
#include <limits>

#include <lcmslam/imaging/io/encoded_frame.hpp>

namespace lcmslam {
namespace {

void shift(CameraEvent& event, Utime by) {
  if (auto* frame = std::get_if<EncodedFrame>(&event)) {
    frame->utime += by;
    for (EncodedImage* image : {&frame->colour, &frame->depth, &frame->amplitude}) image->utime += by;
  } else if (auto* encoders = std::get_if<Encoders>(&event)) {
    encoders->utime += by;
  } else {
    std::get<GroundTruth>(event).utime += by;
  }
}

class RepeatedSource : public CameraSource {
 public:
  RepeatedSource(std::function<std::unique_ptr<CameraSource>()> open, int passes)
      : open_(std::move(open)), source_(open_()), passes_(passes) {}

  const RgbdCalibration& calibration() const override { return source_->calibration(); }
  std::size_t frames() const override { return source_->frames() * static_cast<std::size_t>(passes_); }
  std::vector<std::string> notes() const override { return source_->notes(); }
  std::size_t malformed() const override { return malformed_ + source_->malformed(); }
  std::vector<std::string> warnings() const override { return source_->warnings(); }

  std::optional<CameraEvent> next() override {
    auto event = source_->next();
    if (!event && pass_ + 1 < passes_) {
      constexpr Utime between_frames = 33'333;  // us
      ++pass_;
      shift_ += last_ - first_ + between_frames;
      malformed_ += source_->malformed();
      source_ = open_();
      event = source_->next();
    }
    if (!event) return event;
    first_ = std::min(first_, event_utime(*event));
    last_ = std::max(last_, event_utime(*event));
    shift(*event, shift_);
    return event;
  }

 private:
  std::function<std::unique_ptr<CameraSource>()> open_;
  std::unique_ptr<CameraSource> source_;
  int passes_, pass_ = 0;
  Utime first_ = std::numeric_limits<Utime>::max(), last_ = 0;  // of the source's own times
  Utime shift_ = 0;
  std::size_t malformed_ = 0;
};

}  // namespace

std::unique_ptr<CameraSource> repeat_source(std::function<std::unique_ptr<CameraSource>()> open, int passes) {
  return std::make_unique<RepeatedSource>(std::move(open), passes);
}

}  // namespace lcmslam

#include <algorithm>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/datasets/problem_summary.hpp>
#include "procs/camera/camera_source.hpp"

namespace lcmslam {
namespace {

/// Frames and true poses of a folder, by time.
class DatasetSource : public CameraSource {
 public:
  DatasetSource(const std::string& folder, const DatasetOptions& options, double seconds)
      : source_(open_dataset(folder, options)), folder_(folder) {
    frames_ = source_->size();
    if (seconds > 0 && frames_ > 0) {
      const Utime end = source_->entry(0).utime + static_cast<Utime>(1e6 * seconds);
      while (frames_ > 0 && source_->entry(frames_ - 1).utime > end) --frames_;
    }
    // The truth before the first frame serves nobody.
    const Trajectory& truth = source_->truth();
    while (next_truth_ < truth.size() && frames_ > 0 &&
           truth[next_truth_].utime < source_->entry(0).utime - 1'000'000)
      ++next_truth_;
  }

  const RgbdCalibration& calibration() const override { return source_->calibration(); }
  std::size_t frames() const override { return frames_; }
  std::size_t malformed() const override { return source_->problems().size(); }

  std::vector<std::string> warnings() const override { return summarise_problems(source_->problems()); }

  std::vector<std::string> notes() const override {
    std::vector<std::string> notes = {folder_ + ": " + std::to_string(frames_) + " frames"};
    notes.insert(notes.end(), source_->notes().begin(), source_->notes().end());
    return notes;
  }

  std::optional<CameraEvent> next() override {
    const Trajectory& truth = source_->truth();
    while (next_frame_ < frames_) {
      if (next_truth_ < truth.size() && truth[next_truth_].utime <= source_->entry(next_frame_).utime) {
        const StampedPose& pose = truth[next_truth_++];
        return GroundTruth{pose.utime, source_->truth_frame(), pose.T_world_body};
      }
      auto frame = source_->frame(next_frame_++);
      if (frame) return std::move(*frame);
    }
    // The truth up to a moment after the last frame, so that its pose can be compared too.
    if (frames_ > 0 && next_truth_ < truth.size() &&
        truth[next_truth_].utime <= source_->entry(frames_ - 1).utime + 100'000) {
      const StampedPose& pose = truth[next_truth_++];
      return GroundTruth{pose.utime, source_->truth_frame(), pose.T_world_body};
    }
    return std::nullopt;
  }

 private:
  std::unique_ptr<RgbdSource> source_;
  std::string folder_;
  std::size_t frames_ = 0;
  std::size_t next_frame_ = 0;
  std::size_t next_truth_ = 0;
};

}  // namespace

std::unique_ptr<CameraSource> make_dataset_source(const DatasetSourceSettings& settings) {
  DatasetOptions options;
  options.calibration = settings.calibration;
  options.description = settings.description;
  options.jpeg_quality = settings.jpeg_quality;
  return std::make_unique<DatasetSource>(settings.folder, options, settings.seconds);
}

}  // namespace lcmslam

#pragma once
// Recordings of a colour camera and of a depth camera, read in step.

#include <lcmslam/cameras/camera_device.hpp>
#include <lcmslam/cameras/image_pairs.hpp>

namespace lcmslam {

class PairedRecording : public CameraDevice {
 public:
  PairedRecording(std::unique_ptr<CameraDevice> colour, std::unique_ptr<CameraDevice> depth, ImagePairs pairs)
      : colour_{std::move(colour)}, depth_{std::move(depth)}, pairs_(std::move(pairs)) {}

  std::optional<CameraShot> read(std::chrono::milliseconds patience) override;
  bool ended() const override { return ended_; }
  std::string describe() const override {
    return colour_.device->describe() + "; " + depth_.device->describe();
  }
  const ImagePairs& pairs() const { return pairs_; }

 private:
  struct Recording {
    std::unique_ptr<CameraDevice> device;
    bool begun = false;
    Utime last = 0;  // colour's clock
  };
  bool is_behind(const Recording& recording, const Recording& other) const;

  Recording colour_, depth_;
  ImagePairs pairs_;
  bool ended_ = false;
};

}  // namespace lcmslam

#pragma once
// Settings of sources that are cameras, or stand for one.

#include <filesystem>

#include <lcmslam/cameras/watched_camera.hpp>
#include "procs/camera/drivers/driver_settings.hpp"

namespace lcmslam {

/// What all of them have.
struct LiveSettings {
  std::filesystem::path calibration;
  int jpeg_quality = 90;
  WatchSettings watch;

  void describe(SettingsVisitor& s) {
    s.required_path("calibration", calibration,
                    "of the head (YAML) of ours, or of ROS (camera_info) or OpenCV (FileStorage)");
    s.number("jpeg_quality", jpeg_quality, "", {1, 100}, "of colour images that are not JPEG yet");
    s.section("watch", watch, "a camera that is late, gone or comes back");
  }
};

struct PairSourceSettings {
  DriverSettings colour, depth;
  double tolerance = 0.015;

  PairSourceSettings() { depth.video.images = "depth"; }

  void describe(SettingsVisitor& s) {
    s.section("colour", colour, "the colour camera");
    s.section("depth", depth, "the depth camera");
    s.number("tolerance", tolerance, "s", {0, 0.5},
             "between a colour and a depth image of one moment, at most; half the faster camera's interval "
             "is right");
  }
};

struct ChannelSourceSettings {
  std::string channel = "OPENNI_FRAME";

  void describe(SettingsVisitor& s) {
    s.text("channel", channel,
           "of another driver's bot_core.images_t with a colour image (LEFT) and a depth image");
    s.require(!channel.empty() && channel != "CAMERA", "channel",
              "must be another channel than CAMERA, which needs no relay: see the source `calibration`");
  }
};

}  // namespace lcmslam

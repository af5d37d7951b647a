#pragma once
// How each driver's camera is opened. A recording is opened in a camera's place by its `file`.

#include <string>

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

inline void describe_recording(SettingsVisitor& s, double& start) {
  s.number(
      "start", start, "s", {0, 1e11},
      "stamp of a recording's first image, since 1970; 0: the time at which it is opened (of a pair, for "
      "both)");
}

/// By OpenCV: V4L2 cameras, video files, image sequences.
struct VideoSettings {
  std::string device = "/dev/video0", file, format, images = "colour";
  int width = 0, height = 0;
  double rate = 0, exposure = 0, depth_unit = 0.001, start = 0;
  bool keep_jpeg = true;

  void describe(SettingsVisitor& s) {
    s.text("device", device,
           "V4L2 camera: /dev/video0, or a name below /dev/v4l/by-id that no other plug takes");
    s.text("file", file,
           "instead of a camera, a video, or a sequence of images with their number's place in the name: "
           "left/%06d.png");
    s.choice("images", images, {"colour", "depth"}, "what they show; depth: 16 bits along the optical axis");
    s.text("format", format, "of a camera's pixels, four letters: MJPG, YUYV, Y16; empty: its own choice");
    s.flag("keep_jpeg", keep_jpeg,
           "images that come as JPEG (format MJPG) go out as they are, not decoded and coded again");
    s.number("width", width, "pixels", {0, 8192}, "of a camera's images; 0: the calibration's");
    s.number("height", height, "pixels", {0, 8192}, "of a camera's images; 0: the calibration's");
    s.number("rate", rate, "Hz", {0, 1000}, "of the images, 0: 30; a camera takes what it has next to it");
    s.number("exposure", exposure, "s", {0, 10}, "of a camera; 0: automatic");
    s.number("depth_unit", depth_unit, "m", {1e-6, 1}, "that one step of a depth image's values stands for");
    describe_recording(s, start);
    s.require((width > 0) == (height > 0), width > 0 ? "height" : "width",
              "must be given where the other one is: a camera takes both together");
    s.require(format.empty() || format.size() == 4, "format", "must be four letters: MJPG, YUYV, 'Y16 '");
  }
};

struct OpenNi2Settings {
  std::string device, file;
  int width = 640, height = 480;
  double rate = 30, start = 0;

  void describe(SettingsVisitor& s) {
    s.text("device", device, "URI, as OpenNI2 names it; empty: the first camera");
    s.text("file", file, "instead of a camera, an .oni recording");
    s.number("width", width, "pixels", {1, 8192}, "of both images of a camera");
    s.number("height", height, "pixels", {1, 8192}, "of both images of a camera");
    s.number("rate", rate, "Hz", {1, 1000}, "of both images of a camera");
    describe_recording(s, start);
  }
};

struct FreenectSettings {
  std::string serial;

  void describe(SettingsVisitor& s) { s.text("serial", serial, "of the Kinect; empty: the first one"); }
};

/// One camera by any driver.
struct DriverSettings {
  std::string driver = "video";
  VideoSettings video;
  OpenNi2Settings openni2;
  FreenectSettings freenect;

  void describe(SettingsVisitor& s) {
    s.choice("driver", driver, {"video", "openni2", "freenect"}, "that reads the camera");
    s.alternative(driver == "video", "video", video, "by OpenCV: V4L2 cameras, video files, image sequences");
    s.alternative(driver == "openni2", "openni2", openni2, "by OpenNI2: Xtion, PrimeSense, .oni files");
    s.alternative(driver == "freenect", "freenect", freenect, "by libfreenect: the first Kinect");
  }

  /// Not a camera but a file, which has an end and is read as fast as it is asked for.
  bool is_recording() const {
    return (driver == "video" && !video.file.empty()) || (driver == "openni2" && !openni2.file.empty());
  }
  /// Of a recording.
  double& start() { return driver == "openni2" ? openni2.start : video.start; }
};

}  // namespace lcmslam

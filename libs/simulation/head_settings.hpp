#pragma once
// A sensor head as a file of config/heads describes it.

#include <filesystem>
#include <string>
#include <vector>

#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/settings/settings.hpp>
#include <lcmslam/simulation/camera_faults.hpp>
#include <lcmslam/simulation/depth_camera.hpp>
#include <lcmslam/simulation/tof_camera.hpp>

namespace lcmslam {

struct LensSettings {
  int width = 640, height = 480;
  double fx = 525, fy = 525;
  double cx = 0, cy = 0;
  std::vector<double> distortion;

  void describe(SettingsVisitor& s) {
    s.number("width", width, "pixels", {1, 4096}, "of the image");
    s.number("height", height, "pixels", {1, 4096}, "of the image");
    s.number("fx", fx, "pixels", {1, 1e5}, "focal length");
    s.number("fy", fy, "pixels", {1, 1e5}, "focal length");
    s.number("cx", cx, "pixels", {0, 4096}, "principal point; 0: the image's middle");
    s.number("cy", cy, "pixels", {0, 4096}, "principal point; 0: the image's middle");
    s.numbers("distortion", distortion, "", {-100, 100}, "Brown-Conrady: k1 k2 p1 p2 [k3 [k4 k5 k6]]");
  }
  CameraModel camera() const;
};

struct HeadSettings {
  std::string name;  ///< of the file
  double frame_rate = 30;
  std::string kind = "triangulation";
  LensSettings colour, depth;
  double exposure = 1.0 / 60;
  double rolling_shutter = 0;
  bool depth_rolls = false;
  std::vector<double> translation = {0, 0, 0}, rpy = {0, 0, 0};
  StructuredLightSensor triangulation;
  TofSensor time_of_flight;
  CameraFaults faults = {};

  void describe(SettingsVisitor& s) {
    s.number("frame_rate", frame_rate, "Hz", {0.1, 200}, "of the images");
    s.section("colour", colour, "the colour camera's lens");
    s.section("depth", depth, "the depth camera's lens");
    s.number("exposure", exposure, "s", {0, 0.1}, "of the colour camera: motion blurs over it");
    s.number("rolling_shutter", rolling_shutter, "s", {0, 0.1},
             "from the colour image's first row to its last; 0: a global shutter");
    s.flag("depth_rolls", depth_rolls,
           "the depth camera reads its rows as colour's does; only then a calibration can tell it");
    s.numbers("translation", translation, "m", {-1, 1}, "of the depth camera in the colour camera's frame");
    s.numbers("rpy", rpy, "rad", {-3.2, 3.2}, "of the depth camera in the colour camera's frame");
    s.require(translation.size() == 3, "translation", "must be three numbers");
    s.require(rpy.size() == 3, "rpy", "must be three numbers");
    s.choice("kind", kind, {"triangulation", "time_of_flight"},
             "triangulation: structured light or stereo, whose error is disparity's");
    s.alternative(kind == "triangulation", "triangulation", triangulation, "structured light or stereo");
    s.alternative(kind == "time_of_flight", "time_of_flight", time_of_flight, "phase of modulated light");
    s.section("faults", faults, "what real cameras do besides");
  }
};

/// Throws ConfigError with file and line.
HeadSettings load_head(const std::filesystem::path& file);

}  // namespace lcmslam

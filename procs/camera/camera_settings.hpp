#pragma once
// Section `camera`: where the camera process gets its data, and how fast they go out.

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/settings/settings.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "procs/camera/live_settings.hpp"

namespace lcmslam {

inline void describe_jpeg_quality(SettingsVisitor& s, int& quality) {
  s.number("jpeg_quality", quality, "", {1, 100}, "of colour images that are not JPEG yet");
}

struct SimulationSourceSettings {
  SimulationSettings simulation;
  int jpeg_quality = 90;
  std::string render = "live";

  void describe(SettingsVisitor& s) {
    simulation.describe(s);
    describe_jpeg_quality(s, jpeg_quality);
    s.choice("render", render, {"live", "cached"},
             "cached: rendered once into a log below out/cache, then played from there");
  }
};

struct DatasetSourceSettings {
  std::string folder;
  std::filesystem::path calibration, description;
  int jpeg_quality = 90;
  double seconds = 0;

  void describe(SettingsVisitor& s) {
    s.required("folder", folder, "TUM RGB-D, 7-Scenes, or numbered images");
    s.path("calibration", calibration,
           "calibration (YAML) instead of the data set's own; empty: look for it");
    s.path("description", description,
           "layout of the folder (YAML, see config/datasets); empty: look for it");
    describe_jpeg_quality(s, jpeg_quality);
    s.number("seconds", seconds, "s", {0, 1e9}, "of the recording, from its start; 0: all");
  }
};

struct LogSourceSettings {
  std::string file;

  void describe(SettingsVisitor& s) {
    s.required("file", file, "an .lcmlog with CAMERA, CAMERA_CALIBRATION and, if there are wheels, ENCODERS");
  }
};

struct CalibrationSourceSettings {
  std::filesystem::path file;

  void describe(SettingsVisitor& s) {
    s.required_path("file", file,
                    "calibration (YAML) of ours, or of ROS (camera_info) or OpenCV (FileStorage)");
  }
};

struct CameraSettings {
  std::string source = "simulation";
  SimulationSourceSettings simulation;
  DatasetSourceSettings dataset;
  LogSourceSettings log;
  CalibrationSourceSettings calibration;
  VideoSettings video;
  OpenNi2Settings openni2;
  FreenectSettings freenect;
  PairSourceSettings pair;
  ChannelSourceSettings channel;
  LiveSettings live;
  double speed = 1;
  std::vector<std::string> wait_for;
  double wait_at_most = 30;

  void describe(SettingsVisitor& s) {
    s.choice(
        "source", source,
        {"simulation", "dataset", "log", "calibration", "video", "openni2", "freenect", "pair", "channel"},
        "where the images come from; calibration: from another driver, which has none");
    s.alternative(source == "simulation", "simulation", simulation, "a robot that drives through a scene");
    s.alternative(source == "dataset", "dataset", dataset, "a recording of others");
    s.alternative(source == "log", "log", log, "a recording of ours");
    s.alternative(source == "calibration", "calibration", calibration,
                  "CAMERA_CALIBRATION at 1 Hz beside another driver's CAMERA");
    s.alternative(source == "video", "video", video, "by OpenCV: V4L2 cameras, video files, image sequences");
    s.alternative(source == "openni2", "openni2", openni2, "by OpenNI2: Xtion, PrimeSense, .oni files");
    s.alternative(source == "freenect", "freenect", freenect, "by libfreenect: the first Kinect");
    s.alternative(source == "pair", "pair", pair,
                  "a colour camera and a depth camera, matched by their stamps");
    s.alternative(source == "channel", "channel", channel, "another driver's images become CAMERA");
    s.alternative(is_live_kind(), "live", live, "of video, openni2, freenect, pair and channel");
    s.number("speed", speed, "", {0.01, 100}, "of playing; 1: as it was measured");
    s.texts("wait_for", wait_for, "processes that must report before the first image goes out");
    s.number("wait_at_most", wait_at_most, "s", {0, 600},
             "that the first image waits for the processes of wait_for");
  }

  /// A camera, or a recording in its place.
  bool is_device() const {
    return source == "video" || source == "openni2" || source == "freenect" || source == "pair";
  }
  /// Those, or another driver's channel: they share the section `live`.
  bool is_live_kind() const { return is_device() || source == "channel"; }
};

/// Scenes and calibrations beside a driver are named relative to the file that names them. Throws
/// ConfigError.
CameraSettings read_camera_settings(const ConfigNode& config);

}  // namespace lcmslam

#pragma once
// Simulated drives for the experiments on mapping: rendered once, features found once, mapped as often as
// asked. A changed drive (darker images, other wheels) is a copy that shares nothing.

#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "procs/camera/camera_source.hpp"
#include "tools/batch/batch_graph.hpp"

namespace lcmslam {

struct DriveSettings {
  std::string scene = "kitchen";  ///< of config/scenes
  int seed = 1;                   ///< of the sensors' errors
  double seconds = 0;             ///< 0: the whole path
  double frame_rate = 10;         ///< Hz
  int laps = 1;
};

/// What the experiments have in common, so that they share their drives: 20 s at 4 Hz; quick, 4 s at
/// 3 Hz.
DriveSettings usual_drive(bool quick, const std::string& scene, int seed);

struct Drive {
  RgbdCalibration calibration;
  std::vector<BatchMessage> messages;  ///< CAMERA_CALIBRATION, ENCODERS, CAMERA and FEATURES, in their order
  std::vector<FeatureFrame> frames;    ///< what FEATURES says
  Trajectory truth;                    ///< of the robot
  double seconds = 0;                  ///< from the first message to the last
  /// The scene, for its true surfaces; none for recordings.
  std::shared_ptr<const Simulation> simulation;

  double distance_to_surface(const Eigen::Vector3d& point_world) const;
};

/// Takes all of a source and finds the features with the settings of config/replay.yaml; the thesis's preset
/// finds its own in map_drive(). `truth`: of the robot where the source has none.
Drive take_drive(CameraSource& source);

/// Renders drives and keeps the newest few, by their settings. What is rendered again is the same to the
/// byte.
class DriveStore {
 public:
  /// Throws ConfigError for a scene that is none.
  std::shared_ptr<const Drive> drive(const DriveSettings& settings);

 private:
  std::mutex mutex_;
  std::deque<std::pair<std::string, std::shared_ptr<const Drive>>> kept_;
};

/// The colour image of that stamp, CV_8UC3; empty where there is none.
cv::Mat colour_image(const Drive& drive, Utime utime);

/// Every image decoded, changed and coded anew; features found in what it is then. `number` of the frame
/// from 0, `seconds` since the first message.
using ImageChange = std::function<void(RgbdFrame& frame, int number, double seconds)>;
Drive with_images(const Drive& drive, const ImageChange& change);

/// The mappers are told another calibration than the images were made with.
Drive with_calibration(const Drive& drive, const RgbdCalibration& calibration);

/// Every n-th image, all of the wheels.
Drive every_nth(const Drive& drive, int n);

/// The wheels fall silent from `from` to `to`, s since the first message.
Drive without_wheels(const Drive& drive, double from, double to);

}  // namespace lcmslam

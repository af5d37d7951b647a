#pragma once
// What batch is about to do with a log, settled before any work: what cannot succeed is refused here, with
// its cure.

#include <optional>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include "tools/batch/log_offer.hpp"

namespace lcmslam {

struct BatchPlan {
  ConfigNode config;                   ///< with a source of odometry in the place of `auto`
  std::vector<std::string> processes;  ///< of section `launch` without the camera, for which the log stands
  std::string camera = "CAMERA";       ///< the log's channel of images
  std::int64_t frames = 0;             ///< messages there, or of FEATURES, within the span
  std::vector<std::string> notes;      ///< what was chosen and why, a line each
};

/// `log` names the file in errors; `calibrated`: a calibration comes from elsewhere. Throws ConfigError for
/// wrong settings, and std::runtime_error when the log has no frame, no calibration for its images, or no
/// message of the source of odometry that the configuration names.
BatchPlan plan_batch(const ConfigNode& config, const std::string& log, const LogOffer& offer,
                     bool calibrated);

}  // namespace lcmslam

#pragma once
// Calibrations as a map's file keeps them: the message, without whom and when it came from.

#include <deque>
#include <memory>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/map_store/file/stored_map.hpp>

namespace lcmslam {

StoredCalibration stored(const camera_calibration_t& message);
/// Throws DecodeError.
RgbdCalibration from_stored(const StoredCalibration& calibration);

/// One object for all calibrations by which images read alike (reads_alike), names and mounts aside.
class KnownCalibrations {
 public:
  using Calibration = std::shared_ptr<const RgbdCalibration>;

  Calibration same_as(const RgbdCalibration& calibration);
  /// Of a keyframe's images; null where nobody knows it or it cannot be read.
  Calibration of(const StoredImages& images);

 private:
  std::deque<Calibration> known_;  // a few, the newest first
};

}  // namespace lcmslam

#pragma once
// Systematic errors of a range-bearing sensor, the same for all observations:
//
//   measured range = offset + (1 + scale) range,   measured bearing = turn + bearing
//
// They show in the data themselves: an offset of the range is no other map, a scale contradicts the way that
// the odometry counts, a turn the direction in which it drives. So the smoother estimates them with path and
// map (path_smoother.hpp) from priors that belong to the sensor, and the filter takes them away from what is
// measured next. Calibrated against a truth they would be no property of the recording.

#include <lcmslam/fastslam/landmarks/measurement_model.hpp>

namespace lcmslam {

struct SensorCalibration {
  double range_offset = 0;    ///< m
  double range_scale = 0;     ///< ratio beyond 1
  double bearing_offset = 0;  ///< rad

  /// What a faultless sensor would have measured. Other kinds of measurements stay as they are.
  Measurement corrected(Measurement m) const {
    if (m.kind != MeasurementKind::range_bearing) return m;
    m.value.x() = std::max(0.01, (m.value.x() - range_offset) / (1 + range_scale));
    m.value.y() = std::remainder(m.value.y() - bearing_offset, 2 * M_PI);
    return m;
  }
};

}  // namespace lcmslam

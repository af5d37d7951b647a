// What a sensor's learned errors make of what it says; that they are learned show known_landmarks_test.cpp's
// drives.

#include <lcmslam/fastslam/sensor_calibration.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

TEST(SensorCalibration, CorrectsWhatItSays) {
  const SensorCalibration sensor{0.1, 0.02, -0.03};
  Measurement m;
  m.kind = MeasurementKind::range_bearing;
  m.value << 0.1 + 1.02 * 3, -0.03 + 0.4, 0;
  EXPECT_NEAR(sensor.corrected(m).value.x(), 3, 1e-12);
  EXPECT_NEAR(sensor.corrected(m).value.y(), 0.4, 1e-12);
  m.kind = MeasurementKind::planar;
  EXPECT_EQ(sensor.corrected(m).value, m.value);
}

}  // namespace
}  // namespace lcmslam

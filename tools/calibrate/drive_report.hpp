#pragma once
#include <string>

#include "tools/calibrate/recorded_drive.hpp"

namespace lcmslam {

std::string drive_report(const RecordedDrive& drive, const DriveCalibration& found);
std::string mount_report(const RecordedDrive& drive, const DriveCalibration& found);
std::string wheels_report(const RecordedDrive& drive, const DriveCalibration& found);
/// Why the drive is refused, and what to drive; none: it is good.
std::vector<std::string> mount_doubts(const RecordedDrive& drive, const DriveCalibration& found);
std::vector<std::string> wheels_doubts(const RecordedDrive& drive, const DriveCalibration& found);

}  // namespace lcmslam

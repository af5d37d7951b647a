#include <fmt/format.h>
#include <iostream>

#include <lcmslam/calibration/covariance_text.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/calibrate/calibration_output.hpp"
#include "tools/calibrate/drive_report.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int calibrate_mount_command(int argc, char** argv) {
  std::string log;
  CalibrationOutput output;
  CLI::App app{
      "Where a camera sits on its robot, from a drive: wheels and what the camera sees must tell one motion.",
      "lcmslam calibrate mount"};
  app.add_option("log", log, "an .lcmlog of a drive: CAMERA, and ENCODERS or ODOMETRY")
      ->required()
      ->check(CLI::ExistingFile);
  output.add_to(app, "calibration (YAML) to write");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  output.check();
  install_stop_signals(0);
  RecordedDrive drive = read_drive(log, output.base(std::nullopt));
  const DriveCalibration found =
      calibrate_drive(cut_drive(drive.camera, drive.steps), drive.floor, drive.calibration.T_robot_camera);
  std::cout << drive_report(drive, found) << mount_report(drive, found);
  if (const int refused = refuse(mount_doubts(drive, found), output.accept)) return refused;
  drive.calibration.has_mount = true;
  drive.calibration.T_robot_camera = found.T_robot_camera;
  output.write(
      drive.calibration,
      fmt::format("mount by lcmslam calibrate mount: {:.1f} m of a drive{}.", found.way,
                  found.height_observed ? "" : "; its height is not from it"),
      covariance_text("mount", {"x", "y", "z", "rx", "ry", "rz"}, found.covariance,
                      "T_robot_camera exp(xi): translation (m), then rotation (rad), camera frame."));
  return 0;
}

}  // namespace lcmslam

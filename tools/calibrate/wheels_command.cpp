#include <fmt/format.h>
#include <iostream>

#include <lcmslam/calibration/covariance_text.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/calibrate/calibration_output.hpp"
#include "tools/calibrate/drive_report.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

/// A part of a configuration, for `include`.
std::string wheels_text(const DriveCalibration& found) {
  std::string radii;
  for (const double factor : found.radius_factors)
    radii += (radii.empty() ? "" : ", ") + fmt::format("{:.6f}", factor);
  return fmt::format(
      "# Wheels by lcmslam calibrate wheels: {:.1f} m of a drive. A configuration takes it with `include`.\n"
      "odometry:\n  wheels:\n    radius_factors: [{}]\n    layout_factor: {:.6f}\n",
      found.way, radii, found.layout_factor);
}

}  // namespace

int calibrate_wheels_command(int argc, char** argv) {
  std::string log;
  CalibrationOutput output;
  CLI::App app{
      "Radii and track of a robot's wheels, from a drive: what they count against what the camera sees.",
      "lcmslam calibrate wheels"};
  app.add_option("log", log, "an .lcmlog of a drive: CAMERA and ENCODERS")
      ->required()
      ->check(CLI::ExistingFile);
  output.add_to(app, "part of a configuration (YAML) to write, section odometry");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  output.check();
  install_stop_signals(0);
  const RecordedDrive drive = read_drive(log, output.base(std::nullopt));
  const DriveCalibration found =
      calibrate_drive(cut_drive(drive.camera, drive.steps), drive.floor, drive.calibration.T_robot_camera);
  std::cout << drive_report(drive, found) << wheels_report(drive, found);
  if (drive.wheels.empty())
    throw std::runtime_error(
        "the log has no ENCODERS: a scale of ODOMETRY is its driver's to set, nothing is written");
  if (const int refused = refuse(wheels_doubts(drive, found), output.accept)) return refused;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < found.radius_factors.size(); ++i) names.push_back(fmt::format("radius_{}", i));
  names.emplace_back("layout");
  output.write_text(wheels_text(found),
                    covariance_text("odometry.wheels", names, found.factor_covariance,
                                    "True over stated: radii, then places of the wheels."));
  return 0;
}

}  // namespace lcmslam

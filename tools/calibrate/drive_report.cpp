#include "tools/calibrate/drive_report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "tools/calibrate/units.hpp"

namespace lcmslam {
namespace {

/// Roll, pitch and yaw of the head as a body, as the key mount has them.
Eigen::Vector3d rpy_of(const Eigen::Isometry3d& T_robot_camera) {
  const Eigen::Matrix3d R = (T_robot_camera * optical_axes().inverse()).linear();
  return {std::atan2(R(2, 1), R(2, 2)), -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
          std::atan2(R(1, 0), R(0, 0))};
}

/// A camera that looks backwards sees what wheels that turn backwards would do: of a start that looks ahead
/// the solution is a mount turned by 180 degrees and negative wheels, as sure as the true one. Limits are
/// those of the settings odometry.wheels.
void doubt_factors(const DriveCalibration& found, std::vector<std::string>& missing) {
  constexpr double least = 0.5, most = 2;
  std::vector<double> factors = found.radius_factors;
  factors.push_back(found.layout_factor);
  for (const double factor : factors) {
    if (factor >= least && factor <= most) continue;
    missing.push_back(
        fmt::format("a wheel's radius or the track would be {:.2f} of the stated one: the camera looks "
                    "another way than the "
                    "start assumed, or wheels count backwards or are stated wrongly. Give a calibration with "
                    "a rough mount, "
                    "to 20 degrees (--into), or mend the wheels",
                    factor));
    return;
  }
}

/// The misfit is of the stretches that agree: what a few of them agree on by chance looks as sure as the
/// truth.
void doubt_consensus(const DriveCalibration& found, std::vector<std::string>& missing) {
  if (2 * found.slips <= found.stretches) return;
  missing.push_back(
      fmt::format("wheels and camera disagree in {} of {} stretches: their clocks differ, the wheels slip or "
                  "the camera's calibration is wrong",
                  found.slips, found.stretches));
}

void doubt_tracking(const RecordedDrive& drive, std::vector<std::string>& missing) {
  if (2 * drive.tracked < drive.images)
    missing.emplace_back(
        "the camera was tracked in less than half of the images: drive slowly, before things with texture");
}

/// What a drive lacks whatever it is for.
std::vector<std::string> drive_doubts(const RecordedDrive& drive, const DriveCalibration& found) {
  std::vector<std::string> missing;
  doubt_tracking(drive, missing);
  doubt_factors(found, missing);
  doubt_consensus(found, missing);
  return missing;
}

}  // namespace

std::string drive_report(const RecordedDrive& drive, const DriveCalibration& found) {
  return fmt::format(
      "  camera           tracked in {} of {} images{}\n"
      "  drive            {:.1f} m and {:.0f} degrees of turns in {} stretches; wheels slipped in {}\n"
      "  misfit           {:.2f} standard deviations RMS (1: as noise says)\n",
      drive.tracked, drive.images,
      drive.damaged > 0 ? fmt::format(", {} messages are damaged", drive.damaged) : "", found.way,
      degrees_per_rad * found.turned, found.stretches, found.slips, found.misfit);
}

std::string mount_report(const RecordedDrive& drive, const DriveCalibration& found) {
  const Eigen::Vector3d t = mm_per_m * found.T_robot_camera.translation(),
                        rpy = degrees_per_rad * rpy_of(found.T_robot_camera);
  const Vector6d sigma = found.robot_sigmas();
  std::string text = fmt::format(
      "  camera on robot  x {:.1f} +- {:.1f}, y {:.1f} +- {:.1f} mm\n"
      "                   roll {:.2f} +- {:.2f}, pitch {:.2f} +- {:.2f}, yaw {:.2f} +- {:.2f} degrees\n",
      t.x(), mm_per_m * sigma[0], t.y(), mm_per_m * sigma[1], rpy[0], degrees_per_rad * sigma[3], rpy[1],
      degrees_per_rad * sigma[4], rpy[2], degrees_per_rad * sigma[5]);
  text +=
      found.height_observed
          ? fmt::format("  height           {:.1f} +- {:.1f} mm, from the floor in {} images\n", t.z(),
                        mm_per_m * sigma[2], drive.floor->images)
          : fmt::format(
                "  height           {:.1f} mm as it was: a robot that stays in its plane does not tell it, "
                "and no floor was seen\n",
                t.z());
  return text;
}

std::string wheels_report(const RecordedDrive& drive, const DriveCalibration& found) {
  const Eigen::VectorXd sigma = found.factor_covariance.diagonal().cwiseSqrt();
  std::string text;
  for (std::size_t i = 0; i < found.radius_factors.size(); ++i) {
    const double factor = found.radius_factors[i], s = sigma[static_cast<Eigen::Index>(i)];
    text +=
        drive.wheels.empty()
            ? fmt::format("  way              {:.4f} +- {:.4f} of what ODOMETRY says\n", factor, s)
            : fmt::format("  radius of {}      {:.2f} +- {:.2f} mm ({:.4f} of the stated {:.2f})\n", i,
                          mm_per_m * factor * drive.wheels[i].radius, mm_per_m * s * drive.wheels[i].radius,
                          factor, mm_per_m * drive.wheels[i].radius);
  }
  const double layout = found.layout_factor, s = sigma[sigma.size() - 1];
  double track = 0;
  for (const Wheel& a : drive.wheels)
    for (const Wheel& b : drive.wheels) track = std::max(track, a.y - b.y);
  text += track > 0 ? fmt::format("  track            {:.2f} +- {:.2f} mm ({:.4f} of the stated {:.2f})\n",
                                  mm_per_m * layout * track, mm_per_m * s * track, layout, mm_per_m * track)
                    : fmt::format("  track            {:.4f} +- {:.4f} of the stated one\n", layout, s);
  return text;
}

std::vector<std::string> mount_doubts(const RecordedDrive& drive, const DriveCalibration& found) {
  std::vector<std::string> missing = drive_doubts(drive, found);
  const Vector6d sigma = found.robot_sigmas();
  if (std::max(sigma[0], sigma[1]) > 0.02)
    missing.emplace_back(fmt::format("x and y are known to {:.0f} mm only: turn more, to both sides",
                                     mm_per_m * std::max(sigma[0], sigma[1])));
  if (found.height_observed && sigma[2] > 0.02)
    missing.emplace_back(fmt::format(
        "the height is known to {:.0f} mm only: what was taken for the floor lies at different heights; "
        "let the depth camera see the floor in most images",
        mm_per_m * sigma[2]));
  if (sigma[5] > 0.01)
    missing.emplace_back(fmt::format("yaw is known to {:.2f} degrees only: drive longer straight ways",
                                     degrees_per_rad * sigma[5]));
  if (std::max(sigma[3], sigma[4]) > 0.01)
    missing.emplace_back("roll and pitch are not known: turn more, or let the depth camera see the floor");
  return missing;
}

std::vector<std::string> wheels_doubts(const RecordedDrive& drive, const DriveCalibration& found) {
  std::vector<std::string> missing = drive_doubts(drive, found);
  const Eigen::VectorXd sigma = found.factor_covariance.diagonal().cwiseSqrt();
  if (sigma.head(sigma.size() - 1).maxCoeff() > 0.01)
    missing.emplace_back(
        "radii are known to worse than 1 %: drive farther, some 20 m, straight ways among them");
  if (sigma[sigma.size() - 1] > 0.01)
    missing.emplace_back("the track is known to worse than 1 %: turn more, to both sides, some full circles");
  return missing;
}

}  // namespace lcmslam

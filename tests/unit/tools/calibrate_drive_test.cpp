// `calibrate mount` and `calibrate wheels` as a user runs them, on a drive through the rendered kitchen in
// figures of eight: images tracked, wheels counted, and both files compared with the mount and the wheels
// that are true.

#include <gmock/gmock.h>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/calibration_text.hpp>
#include <lcmslam/simulation/scene.hpp>
#include <lcmslam/simulation/wheel_base.hpp>
#include "procs/camera/camera_log.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

constexpr double degree = M_PI / 180;
constexpr double left_factor = 1.03, right_factor = 0.98, track_factor = 1.02;  // true over stated

/// A drive whose wheels are replaced by others.
class OtherWheels : public CameraSource {
 public:
  OtherWheels(std::unique_ptr<CameraSource> drive, std::vector<Encoders> readings)
      : drive_(std::move(drive)), readings_(std::move(readings)) {}
  const RgbdCalibration& calibration() const override { return drive_->calibration(); }
  std::size_t frames() const override { return drive_->frames(); }
  std::optional<CameraEvent> next() override {
    auto event = drive_->next();
    if (!event || !std::holds_alternative<Encoders>(*event)) return event;
    return readings_.at(next_++);
  }

 private:
  std::unique_ptr<CameraSource> drive_;
  std::vector<Encoders> readings_;
  std::size_t next_ = 0;
};

/// Standard deviations of a mount's place and rotation along the robot's axes, from the file that has its
/// covariance along the camera's.
Vector6d told_sigmas(const std::string& file, const Eigen::Matrix3d& R) {
  std::ifstream stream(file);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  text.erase(0, text.find("covariance:") + 11);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '[' || c == ']' || c == ','; }, ' ');
  std::istringstream rows(text);
  Matrix6d covariance = Matrix6d::Constant(std::nan(""));
  for (int i = 0; i < 6; ++i) {
    rows >> text;  // "-"
    for (int k = 0; k < 6; ++k) rows >> covariance(i, k);
  }
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = R;
  return (turn * covariance * turn.transpose()).diagonal().cwiseSqrt();
}

/// One drive for all tests.
class CalibrateDrive : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new testing::ScratchFolder;
    SimulationSourceSettings settings;
    settings.simulation.scene = source_folder() / "config/scenes/kitchen_eight.yaml";
    settings.simulation.seconds = 30;
    settings.simulation.frame_rate = 5;
    settings.simulation.threads = 2;
    // What wheels do that no calibration takes away, and no scale but that of what is told of them.
    WheelErrors errors;
    errors.translation_scale = errors.lateral_scale = errors.rotation_scale = errors.slip_every = 0;
    const Scene scene = load_scene(settings.simulation.scene);
    auto readings =
        simulate_encoders(PlanarPath(control_points(scene, 1)), "differential", 1'000'000, 1, errors);
    for (Encoders& reading : readings) {
      reading.wheels[0].radius /= left_factor, reading.wheels[1].radius /= right_factor;
      for (Wheel& wheel : reading.wheels) wheel.y /= track_factor;
    }
    OtherWheels drive(make_live_simulation(settings), readings);
    truth_ = drive.calibration();
    write_log(drive, path("drive.lcmlog"));
  }
  static void TearDownTestSuite() { delete scratch_; }

  static std::string path(const std::string& name) { return (scratch_->path() / name).string(); }
  static testing::CommandRun calibrate(std::vector<std::string> arguments) {
    return testing::run_command({"calibrate", calibrate_command}, std::move(arguments));
  }

  static testing::ScratchFolder* scratch_;
  static RgbdCalibration truth_;
};
testing::ScratchFolder* CalibrateDrive::scratch_ = nullptr;
RgbdCalibration CalibrateDrive::truth_;

// 12 m tell x and y to 3.5 mm, as the command says itself: the 2 mm that docs/CALIBRATION.md tells of are of
// 60 m. The height comes from a time-of-flight camera's floor, whose ranges wiggle by 6 mm and nobody is
// told.
TEST_F(CalibrateDrive, MountFindsWhereTheCameraSits) {
  RgbdCalibration rough = truth_;
  Vector6d step;  // 2 cm and 1 degree beside, on each axis
  step << 0.02, -0.02, 0.02, degree, -degree, degree;
  rough.T_robot_camera = truth_.T_robot_camera * se3_exp(step);
  std::ofstream(path("rough.yaml")) << calibration_text(rough);
  const auto run =
      calibrate({"mount", path("drive.lcmlog"), "--into", path("rough.yaml"), "-o", path("mount.yaml")});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.errors;
  const RgbdCalibration found = load_calibration(path("mount.yaml"));
  const Eigen::Vector3d off = found.T_robot_camera.translation() - truth_.T_robot_camera.translation();
  EXPECT_LT(off.head<2>().norm(), 0.005) << run.out;
  EXPECT_LT(std::abs(off.z()), 0.01) << run.out;
  const Vector6d sigmas = told_sigmas(path("mount_covariance.yaml"), found.T_robot_camera.linear());
  EXPECT_LT(std::abs(off.z()), 2 * sigmas[2]) << "its ranges wiggle, and it knows that: " << run.out;
  EXPECT_LT(off.head<2>().norm(), 3 * sigmas.head<2>().norm()) << run.out;
  EXPECT_LT(angle_between(found.T_robot_camera, truth_.T_robot_camera), 0.3 * degree) << run.out;
  EXPECT_TRUE(found.has_mount);
  EXPECT_TRUE(found.colour == truth_.colour) << "other values stay";
}

// Radii to half a per cent and the track to one, twice what the command says of this drive; told they were 2
// and 3 % off.
TEST_F(CalibrateDrive, WheelsFindsRadiiAndTrack) {
  const auto run = calibrate({"wheels", path("drive.lcmlog"), "-o", path("wheels.yaml")});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.errors;
  const ConfigNode config = ConfigNode::load(path("wheels.yaml"));
  const ConfigNode wheels = config.section("odometry").section("wheels");
  const auto radii = wheels.get("radius_factors", std::vector<double>{});
  ASSERT_EQ(radii.size(), 2U);
  EXPECT_NEAR(radii[0], left_factor, 0.005);
  EXPECT_NEAR(radii[1], right_factor, 0.005);
  EXPECT_NEAR(wheels.get("layout_factor", 1.0), track_factor, 0.01);
}

}  // namespace
}  // namespace lcmslam

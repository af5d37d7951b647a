#include <lcmslam/calibration/camera_tracker.hpp>

#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/odometry/visual_odometry.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {
namespace {

RgbdCalibration without_mount(RgbdCalibration calibration) {
  calibration.has_mount = false;
  calibration.T_robot_camera = Eigen::Isometry3d::Identity();  // its own motion is asked for
  return calibration;
}

SurfSettings many_features() {
  SurfSettings settings;
  settings.hessian_threshold = 10;
  settings.budget.max_features = 600;
  return settings;
}

}  // namespace

struct CameraTracker::Parts {
  explicit Parts(const RgbdCalibration& calibration)
      : registration(without_mount(calibration)), surf(many_features()), odometry({}, Random(1)) {}

  /// Both images are of different moments: the camera's own velocity brings depth to colour's.
  Eigen::Isometry3d motion_between_shots(const RgbdFrame& frame) const {
    const Utime apart = registration.calibration().depth_time(frame.depth_utime) - frame.utime;
    return se3_exp(1e-6 * static_cast<double>(apart) * velocity);
  }

  DepthRegistration registration;
  Surf surf;
  VisualOdometry odometry;
  std::optional<MotionSample> last;
  Vector6d velocity = Vector6d::Zero();  // camera frame, m/s and rad/s
};

CameraTracker::CameraTracker(const RgbdCalibration& calibration)
    : parts_(std::make_unique<Parts>(calibration)) {}

CameraTracker::~CameraTracker() = default;

std::optional<MotionSample> CameraTracker::add(const RgbdFrame& frame) {
  Parts& p = *parts_;
  FeatureFrame features = describe_frame(frame, p.registration, p.motion_between_shots(frame), p.surf);
  features.T_robot_camera = Eigen::Isometry3d::Identity();
  const auto sample = p.odometry.update(features);
  if (!sample || p.odometry.report().status != VisualStatus::tracking) {
    p.last.reset();
    return std::nullopt;
  }
  if (p.last && sample->utime > p.last->utime)
    p.velocity = se3_log(p.last->T_odom_robot.inverse() * sample->T_odom_robot) /
                 (1e-6 * static_cast<double>(sample->utime - p.last->utime));
  p.last = sample;
  return sample;
}

}  // namespace lcmslam

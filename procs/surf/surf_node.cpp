#include "surf/surf_node.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "messages/camera_messages.hpp"
#include "messages/feature_messages.hpp"
#include "messages/motion_messages.hpp"

namespace lcmslam {
namespace {

SurfSettings read_settings(const ConfigNode& config) {
  SurfSettings s;
  s.hessian_threshold = config.get("hessian_threshold", s.hessian_threshold, Range{0, 1e6});
  s.octaves = config.get("octaves", s.octaves, Range{1, 6});
  s.intervals = config.get("intervals", s.intervals, Range{3, 8});
  s.upright = config.get("upright", s.upright);
  s.budget.max_features = config.get("max_features", s.budget.max_features, Range{1, 5000});
  return s;
}

/// Mean absolute horizontal gradient: falls with motion blur and low texture.
float sharpness(const cv::Mat& grey) {
  const int rows = grey.rows / 4 * 4;
  double sum = 0;
  for (int y = 0; y < rows; y += 4) {
    const auto* row = grey.ptr<std::uint8_t>(y);
    int line = 0;
    for (int x = 1; x < grey.cols; ++x) line += std::abs(row[x] - row[x - 1]);
    sum += line;
  }
  return static_cast<float>(sum / std::max(1.0, 0.25 * rows * (grey.cols - 1)));
}

}  // namespace

SurfNode::SurfNode(const ConfigNode& config, Publisher& publisher)
    : publisher_(publisher), surf_(read_settings(config)), frame_queue_(frame_queue(config, 2)) {}

void SurfNode::connect(Inputs& inputs) {
  inputs.subscribe<images_t>("CAMERA", frame_queue_, [this](const images_t& m) { on_camera(m); }).primary =
      true;
  inputs.subscribe<camera_calibration_t>("CAMERA_CALIBRATION", 10,
                                         [this](const camera_calibration_t& m) { on_calibration(m); });
  inputs.subscribe<odometry_t>("ODOMETRY", 200, [this](const odometry_t& m) { on_odometry(m); });
}

void SurfNode::on_calibration(const camera_calibration_t& message) {
  if (registration_ && same_calibration(message, calibration_message_)) return;
  registration_.emplace(from_message(message));
  calibration_message_ = message;
  if (uncalibrated_) on_camera(*std::exchange(uncalibrated_, std::nullopt));
}

void SurfNode::on_odometry(const odometry_t& message) {
  if (message.source == "visual") return;
  constexpr Utime little = 1'000'000;  // us; a sample that comes twice or late is left out
  const MotionSample sample = from_message(message);
  const bool late = sample.utime <= motion_.newest() && motion_.newest() - sample.utime < little;
  if (!late) motion_.add(sample);
}

void SurfNode::on_camera(const images_t& message) {
  if (!registration_) {
    uncalibrated_ = message;
    return;
  }
  publisher_.publish("FEATURES", to_message(describe(decode_images(message, registration_->calibration()))));
  ++frames_;
}

Eigen::Isometry3d SurfNode::motion_between_shots(const RgbdFrame& frame) const {
  const RgbdCalibration& c = registration_->calibration();
  // Odometry's newest sample is a little older than the images: the last velocity bridges the gap.
  constexpr Utime longest_gap = 60'000;
  const auto motion = motion_.between(frame.utime, c.depth_time(frame.depth_utime), longest_gap);
  if (!motion) return Eigen::Isometry3d::Identity();
  return c.T_robot_camera.inverse() * motion->T_from_to * c.T_robot_camera;
}

FeatureFrame SurfNode::describe(const RgbdFrame& frame) {
  const RgbdCalibration& calibration = registration_->calibration();
  cv::Mat grey;
  cv::cvtColor(frame.colour, grey, cv::COLOR_BGR2GRAY);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  surf_.detectAndCompute(grey, cv::noArray(), keypoints, descriptors);

  std::vector<cv::Point2f> pixels;
  for (const auto& keypoint : keypoints) pixels.push_back(keypoint.pt);
  const RegisteredDepth depth = (*registration_)(frame, motion_between_shots(frame));
  const std::vector<DepthAtPixel> points = depth_at_pixels(depth, calibration, pixels);

  FeatureFrame result;
  result.utime = frame.utime;
  result.seq = frame.seq;
  result.sensor = frame.sensor;
  result.width = frame.colour.cols;
  result.height = frame.colour.rows;
  result.fx = calibration.colour.fx;
  result.fy = calibration.colour.fy;
  result.cx = calibration.colour.cx;
  result.cy = calibration.colour.cy;
  result.pixel_sigma = calibration.pixel_sigma;
  result.sharpness = sharpness(grey);
  result.has_mount = calibration.has_mount;
  result.T_robot_camera = calibration.T_robot_camera;
  with_depth_ = 0;
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const cv::KeyPoint& k = keypoints[i];
    const Eigen::Vector2d ideal = calibration.colour.undistort({k.pt.x, k.pt.y});
    Feature f;
    f.x = static_cast<float>(ideal.x());
    f.y = static_cast<float>(ideal.y());
    f.size = k.size;
    f.angle = k.angle * static_cast<float>(CV_PI / 180);
    f.response = k.response;
    f.laplacian = static_cast<std::int8_t>(k.class_id);
    f.octave = static_cast<std::int8_t>(k.octave);
    f.point = points[i].point;
    f.depth_sigma = points[i].sigma;
    if (f.point.allFinite()) {
      f.kind = MeasurementKind::point;
      ++with_depth_;
    }
    const auto bgr = frame.colour.at<cv::Vec3b>(cvRound(k.pt.y), cvRound(k.pt.x));
    f.colour = {bgr[2], bgr[1], bgr[0]};
    f.descriptor = to_bytes(descriptors.ptr<float>(static_cast<int>(i)));
    result.features.push_back(f);
  }
  keypoints_ = static_cast<double>(keypoints.size());
  return result;
}

NodeReport SurfNode::report() const {
  NodeReport report;
  if (!registration_) report.detail = "waits for CAMERA_CALIBRATION";
  report.values = {
      {"frames", static_cast<double>(frames_)}, {"keypoints", keypoints_}, {"with_depth", with_depth_}};
  return report;
}

}  // namespace lcmslam

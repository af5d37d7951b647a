#include <lcmslam/rgbd/describe_frame.hpp>

#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>

#include <lcmslam/imaging/sharpness.hpp>

namespace lcmslam {
namespace {

constexpr int descriptor_length = std::tuple_size_v<Descriptor>;

FeatureFrame frame_of(const RgbdFrame& frame, const RgbdCalibration& calibration) {
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
  result.has_mount = calibration.has_mount;
  result.T_robot_camera = calibration.T_robot_camera;
  return result;
}

Feature feature_of(const cv::KeyPoint& k, const float* descriptor, const DepthAtPixel& depth,
                   const CameraModel& camera, const cv::Mat& colour) {
  const Eigen::Vector2d ideal = camera.undistort({k.pt.x, k.pt.y});
  Feature f;
  f.x = static_cast<float>(ideal.x());
  f.y = static_cast<float>(ideal.y());
  f.size = k.size;
  f.angle = k.angle * static_cast<float>(CV_PI / 180);
  f.response = k.response;
  f.laplacian = static_cast<std::int8_t>(k.class_id);
  f.octave = static_cast<std::int8_t>(k.octave);
  f.point = depth.point;
  f.depth_sigma = depth.sigma;
  if (f.point.allFinite()) f.kind = MeasurementKind::point;
  const auto bgr = colour.at<cv::Vec3b>(cvRound(k.pt.y), cvRound(k.pt.x));
  f.colour = {bgr[2], bgr[1], bgr[0]};
  f.descriptor = to_bytes(descriptor);
  return f;
}

// `depth_at(pixels)` gives the depths of colour's pixels.
template <class DepthAt>
FeatureFrame describe(const RgbdFrame& frame, const RgbdCalibration& calibration, cv::Feature2D& detector,
                      const DepthAt& depth_at) {
  cv::Mat grey, descriptors;
  cv::cvtColor(frame.colour, grey, cv::COLOR_BGR2GRAY);
  std::vector<cv::KeyPoint> keypoints;
  detector.detectAndCompute(grey, cv::noArray(), keypoints, descriptors);
  if (!keypoints.empty() && (descriptors.type() != CV_32FC1 || descriptors.cols != descriptor_length))
    throw std::invalid_argument("describe_frame: the detector must give 64 floats a feature");
  std::vector<cv::Point2f> pixels;
  for (const auto& keypoint : keypoints) pixels.push_back(keypoint.pt);
  const std::vector<DepthAtPixel> points = depth_at(pixels);

  FeatureFrame result = frame_of(frame, calibration);
  result.sharpness = sharpness(grey);
  for (std::size_t i = 0; i < keypoints.size(); ++i)
    result.features.push_back(feature_of(keypoints[i], descriptors.ptr<float>(static_cast<int>(i)), points[i],
                                         calibration.colour, frame.colour));
  return result;
}

}  // namespace

FeatureFrame describe_frame(const RgbdFrame& frame, const RegisteredDepth& depth,
                            const RgbdCalibration& calibration, cv::Feature2D& detector) {
  return describe(frame, calibration, detector,
                  [&](const auto& pixels) { return depth_at_pixels(depth, calibration, pixels); });
}

FeatureFrame describe_frame(const RgbdFrame& frame, const DepthRegistration& registration,
                            const Eigen::Isometry3d& T_colour_depth_time, cv::Feature2D& detector) {
  return describe(frame, registration.calibration(), detector, [&](const auto& pixels) {
    return registration.depth_at_pixels(frame, pixels, T_colour_depth_time);
  });
}

}  // namespace lcmslam

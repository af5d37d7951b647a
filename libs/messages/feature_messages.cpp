#include <lcmslam/messages/feature_messages.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam {
namespace {

feature_t to_message(const Feature& f) {
  feature_t m;
  m.x = f.x;
  m.y = f.y;
  m.size = f.size;
  m.angle = f.angle;
  m.response = f.response;
  m.laplacian = f.laplacian;
  m.octave = f.octave;
  m.kind = static_cast<int8_t>(f.kind);
  for (int i = 0; i < 3; ++i) m.point[i] = f.point(i);
  m.depth_sigma = f.depth_sigma;
  m.landmark_id = f.landmark_id;
  std::copy(f.colour.begin(), f.colour.end(), m.colour);
  std::copy(f.descriptor.begin(), f.descriptor.end(), m.descriptor);
  return m;
}

Feature from_message(const feature_t& m) {
  check_range(m.kind, feature_t::POINT, feature_t::RANGE_BEARING, "feature kind");
  Feature f;
  f.x = m.x;
  f.y = m.y;
  f.size = m.size;
  f.angle = m.angle;
  f.response = m.response;
  f.laplacian = m.laplacian;
  f.octave = m.octave;
  f.kind = static_cast<MeasurementKind>(m.kind);
  f.point = Eigen::Vector3f(m.point[0], m.point[1], m.point[2]);
  f.depth_sigma = m.depth_sigma;
  f.landmark_id = m.landmark_id;
  std::copy(std::begin(m.colour), std::end(m.colour), f.colour.begin());
  std::copy(std::begin(m.descriptor), std::end(m.descriptor), f.descriptor.begin());
  const bool depth_is_sound =
      f.point.z() > 0 && f.point.norm() < 1e4F && f.depth_sigma > 0 && f.depth_sigma < 1e3F;
  if (f.kind == MeasurementKind::point && !depth_is_sound) f.kind = MeasurementKind::bearing;
  return f;
}

}  // namespace

features_t to_message(const FeatureFrame& frame) {
  features_t m;
  m.utime = frame.utime;
  m.frame_seq = frame.seq;
  m.sensor = frame.sensor;
  m.width = frame.width;
  m.height = frame.height;
  m.fx = frame.fx;
  m.fy = frame.fy;
  m.cx = frame.cx;
  m.cy = frame.cy;
  m.pixel_sigma = frame.pixel_sigma;
  m.has_mount = frame.has_mount;
  m.T_robot_camera = to_message(frame.T_robot_camera);
  m.sharpness = frame.sharpness;
  m.n_features = static_cast<int32_t>(frame.features.size());
  m.features.reserve(frame.features.size());
  for (const Feature& f : frame.features) m.features.push_back(to_message(f));
  return m;
}

FeatureFrame from_message(const features_t& m) {
  check_range(m.width, 1, 16384, "width");
  check_range(m.height, 1, 16384, "height");
  check_range(m.fx, 1, 1e6, "fx");
  check_range(m.fy, 1, 1e6, "fy");
  check_range(m.cx, -1e6, 1e6, "cx");
  check_range(m.cy, -1e6, 1e6, "cy");
  check_range(m.pixel_sigma, 1e-3, 1e3, "pixel_sigma");
  FeatureFrame frame;
  frame.utime = m.utime;
  frame.seq = m.frame_seq;
  frame.sensor = m.sensor;
  frame.width = m.width;
  frame.height = m.height;
  frame.fx = m.fx;
  frame.fy = m.fy;
  frame.cx = m.cx;
  frame.cy = m.cy;
  frame.pixel_sigma = m.pixel_sigma;
  frame.has_mount = m.has_mount != 0;
  frame.T_robot_camera = from_message(m.T_robot_camera, "T_robot_camera");
  frame.sharpness = m.sharpness;
  frame.features.reserve(m.features.size());
  for (const feature_t& f : m.features) {
    Feature feature = from_message(f);
    const bool placed = std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.size) &&
                        std::isfinite(f.angle) && std::isfinite(f.response);
    const bool measured = feature.kind == MeasurementKind::bearing || feature.point.allFinite();
    if (placed && measured) frame.features.push_back(feature);
  }
  return frame;
}

}  // namespace lcmslam

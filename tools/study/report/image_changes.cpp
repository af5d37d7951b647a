#include "tools/study/report/image_changes.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace lcmslam {
namespace {

constexpr double radius = 0.25, height = 1.75, ahead = 2.0, aside = 1.2, speed = 0.8;  // m, m/s

/// Where she stands: to and fro on a line across the robot's heading.
Eigen::Vector2d person_in_robot_frame(double seconds) {
  const double turn = 4 * aside / speed, phase = std::fmod(seconds, turn) / turn;  // 0 to 1
  return {ahead, aside * (phase < 0.5 ? 1 - 4 * phase : 4 * phase - 3)};
}

/// A ray against her: how far along it and where on her, in the frame of her feet.
struct PersonHit {
  double distance;  ///< in lengths of the ray
  double angle, z;  ///< rad, m
};
std::optional<PersonHit> hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const double a = ray.head<2>().squaredNorm(), b = origin.head<2>().dot(ray.head<2>()),
               c = origin.head<2>().squaredNorm() - radius * radius, root = b * b - a * c;
  if (root <= 0 || c <= 0) return std::nullopt;
  const double t = (-b - std::sqrt(root)) / a;
  const Eigen::Vector3d p = origin + t * ray;
  if (t <= 0 || p.z() < 0 || p.z() > height) return std::nullopt;
  return PersonHit{t, std::atan2(p.y(), p.x()), p.z()};
}

/// A shirt with checks of 6 cm in four shades.
cv::Vec3b shirt(const PersonHit& at) {
  const int column = static_cast<int>(std::floor(radius * at.angle / 0.06)) & 255,
            row = static_cast<int>(std::floor(at.z / 0.06));
  const int shade = (column * 7 + row * 13 + column * row) & 3;
  return {static_cast<std::uint8_t>(60 + 50 * shade), static_cast<std::uint8_t>(200 - 45 * shade),
          static_cast<std::uint8_t>(90 + 30 * shade)};
}

template <class Paint>
void paint_person(const cv::Size& size, const CameraModel& camera, const Eigen::Isometry3d& T_person_camera,
                  const Paint& paint) {
  const cv::Mat rays = ray_table(camera);
  const Eigen::Vector3d origin = T_person_camera.translation();
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const cv::Vec2f& r = rays.at<cv::Vec2f>(v, u);
      const Eigen::Vector3d ray = T_person_camera.linear() * Eigen::Vector3d(r[0], r[1], 1);
      if (const auto at = hit(origin, ray)) paint(v, u, *at);
    }
}

}  // namespace

ImageChange dimmed(double factor) {
  return [factor](RgbdFrame& frame, int, double) { frame.colour.convertTo(frame.colour, -1, factor); };
}

ImageChange smoothed(double left) {
  return [left](RgbdFrame& frame, int, double) {
    cv::Mat mean;
    cv::blur(frame.colour, mean, {25, 25});
    cv::addWeighted(frame.colour, left, mean, 1 - left, 0, frame.colour);
  };
}

ImageChange flickering(double stops) {
  return [stops](RgbdFrame& frame, int, double seconds) {
    frame.colour.convertTo(frame.colour, -1, std::exp2(stops * std::sin(2 * M_PI * seconds / 3)));
  };
}

ImageChange with_person(const Drive& drive) {
  return [calibration = drive.calibration](RgbdFrame& frame, int, double seconds) {
    const Eigen::Vector2d at = person_in_robot_frame(seconds);
    const Eigen::Isometry3d T_person_camera =
        Eigen::Translation3d(-at.x(), -at.y(), 0) * calibration.T_robot_camera;
    paint_person(frame.colour.size(), calibration.colour, T_person_camera,
                 [&](int v, int u, const PersonHit& h) { frame.colour.at<cv::Vec3b>(v, u) = shirt(h); });
    paint_person(frame.depth.size(), calibration.depth, T_person_camera * calibration.T_colour_depth,
                 [&](int v, int u, const PersonHit& h) {
                   auto& depth = frame.depth.at<std::uint16_t>(v, u);
                   const auto hers = static_cast<std::uint16_t>(std::lround(1000 * h.distance));
                   if (depth == 0 || hers < depth) depth = hers;
                 });
  };
}

}  // namespace lcmslam

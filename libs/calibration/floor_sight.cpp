#include <lcmslam/calibration/floor_sight.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/planes/frame_planes.hpp>

namespace lcmslam {
namespace {

constexpr double largest_doubt = 25 * M_PI / 180;           // rad, between expected and found up
constexpr double lowest_camera = 0.05, highest_camera = 4;  // m
constexpr double least_known = 0.02;                        // m, of a plane's height below the camera
constexpr std::size_t fewest_images = 10;
// What all images share: a floor that is nowhere quite flat, and what depth errs by alike. Of the height that
// is the constant part of the depth noise, which holds what ranges wiggle by, until that was calibrated.
constexpr double shared_up = 0.0012, shared_height = 0.002;  // rad, m

/// Median, and how sure it is by the scatter of the values; images a few frames apart err alike.
std::pair<double, double> middle_of(std::vector<double> values) {
  constexpr double frames_alike = 10;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const double median = *middle;
  for (double& v : values) v = std::abs(v - median);
  std::nth_element(values.begin(), middle, values.end());
  const double independent = std::max(1.0, static_cast<double>(values.size()) / frames_alike);
  return {median, 1.2533 * 1.4826 * *middle / std::sqrt(independent)};
}

/// How far two thirds of the heights reach from their middle where that is farther than one floor: what lies
/// at several heights is no surer for being seen often. 0 where it is one.
double contradiction(std::vector<double> heights, double middle) {
  constexpr double one_floor = 0.05;  // m
  for (double& height : heights) height = std::abs(height - middle);
  const auto most = heights.begin() + static_cast<std::ptrdiff_t>(2 * heights.size() / 3);
  std::nth_element(heights.begin(), most, heights.end());
  return *most > one_floor ? *most : 0;
}

/// Of the height over a plane of the depth camera: a tilt counts by the way from the plane's middle to the
/// camera's foot.
double height_sigma_of(const PlaneFit& fit) {
  const Eigen::Vector3d& up = fit.plane.normal;
  const Eigen::Vector3d way = -fit.plane.offset * up - fit.centre;
  const double along = way.dot(fit.axis), across = way.dot(up.cross(fit.axis));
  return std::sqrt(fit.variance[0] * across * across + fit.variance[1] * along * along + fit.variance[2]);
}

}  // namespace

struct FloorWatch::Parts {
  Parts(const RgbdCalibration& calibration, const Eigen::Isometry3d& expected)
      : finder(calibration),
        T_colour_depth(calibration.T_colour_depth),
        shared_range(calibration.depth_error.has_range_error() ? 0 : calibration.depth_noise.constant),
        up(expected.linear().transpose() * Eigen::Vector3d::UnitZ()) {}

  FramePlaneFinder finder;
  Eigen::Isometry3d T_colour_depth;
  double shared_range;  // sigma, m
  Eigen::Vector3d up;   // expected, colour camera's frame
  std::vector<double> normals[3], heights;
};

FloorWatch::FloorWatch(const RgbdCalibration& calibration, const Eigen::Isometry3d& expected)
    : parts_(std::make_unique<Parts>(calibration, expected)) {}

FloorWatch::~FloorWatch() = default;

// Table tops are level, too: the floor is the lowest of what is level. Where it meets a wall, pixels of both
// make slivers that look about upwards by chance, and lie lower still below the camera: their tilt is noise.
void FloorWatch::add(const cv::Mat& depth) {
  Parts& p = *parts_;
  std::optional<PlaneEquation> lowest;
  for (const FramePlane& found : p.finder(depth).planes) {
    if (height_sigma_of(found.fit) > least_known) continue;
    PlaneEquation plane;
    plane.normal = p.T_colour_depth.linear() * found.fit.plane.normal;
    plane.offset = found.fit.plane.offset - plane.normal.dot(p.T_colour_depth.translation());
    if (std::acos(std::clamp(plane.normal.dot(p.up), -1.0, 1.0)) > largest_doubt) continue;
    if (!lowest || plane.offset > lowest->offset) lowest = plane;
  }
  if (!lowest || lowest->offset < lowest_camera || lowest->offset > highest_camera) return;
  for (int i = 0; i < 3; ++i) p.normals[i].push_back(lowest->normal[i]);
  p.heights.push_back(lowest->offset);
}

std::optional<FloorSight> FloorWatch::sight() const {
  const Parts& p = *parts_;
  if (p.heights.size() < fewest_images) return std::nullopt;
  // Robots pass by tables: what most images show is the floor, what is far from their median is not.
  FloorSight sight;
  double scatter = 0;
  for (int i = 0; i < 3; ++i) {
    const auto [median, sigma] = middle_of(p.normals[i]);
    sight.up[i] = median;
    scatter = std::max(scatter, sigma);
  }
  sight.up.normalize();
  const auto [height, height_sigma] = middle_of(p.heights);
  sight.height = height;
  sight.up_sigma = std::hypot(scatter, shared_up);
  const double seen_sigma = std::hypot(height_sigma, contradiction(p.heights, height));
  sight.height_sigma = std::hypot(seen_sigma, shared_height, p.shared_range);
  sight.images = static_cast<int>(p.heights.size());
  return sight;
}

}  // namespace lcmslam

#include <lcmslam/rgbd/plausibility.hpp>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr double most_outside = 0.3;                 // share of the depths outside of the sensor's range
constexpr double least_filled = 0.02;                // share of the pixels with a depth
constexpr double all_far = 3.5, all_near = 1.0;      // m: no room is like that
constexpr double usual_near = 0.6, usual_far = 4.5;  // m, between which the median depth of rooms lies
constexpr std::array<double, 8> usual_mistakes = {5, 0.2, 10, 0.1, 1000, 0.001, 25.4, 0.0254};

constexpr double within = 15 * M_PI / 180;  // rad
constexpr double least_aligned = 0.45;      // share of the surfaces that stand or lie, in rooms
constexpr double below_floor = -0.3;        // m
constexpr double most_below = 0.15;         // share of the surfaces
constexpr std::size_t least_surfaces = 2000;

constexpr std::size_t least_edges = 3000;
constexpr double least_shift = 0.012, least_scale = 0.03;  // of the image's width; of 1
constexpr double least_gain = 1.25, least_contrast = 1.15;

}  // namespace

void DepthHistogram::add(const cv::Mat& depth_mm) {
  for (int row = 0; row < depth_mm.rows; ++row)
    for (int column = 0; column < depth_mm.cols; ++column) {
      const int mm = depth_mm.at<std::uint16_t>(row, column);
      if (mm == 0) continue;
      ++counts_[static_cast<std::size_t>(mm / bin)];
      ++depths_;
    }
  pixels_ += static_cast<std::int64_t>(depth_mm.total());
}

double DepthHistogram::filled() const {
  return pixels_ == 0 ? 0 : static_cast<double>(depths_) / static_cast<double>(pixels_);
}

double DepthHistogram::quantile(double share) const {
  const double wanted = share * static_cast<double>(depths_);
  double sum = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    sum += static_cast<double>(counts_[i]);
    if (sum >= wanted && sum > 0) return 1e-3 * bin * (static_cast<double>(i) + 0.5);
  }
  return 0;
}

double DepthHistogram::share_between(double near, double far) const {
  double sum = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const double depth = 1e-3 * bin * (static_cast<double>(i) + 0.5);
    if (depth >= near && depth <= far) sum += static_cast<double>(counts_[i]);
  }
  return depths_ == 0 ? 0 : sum / static_cast<double>(depths_);
}

std::string DepthHistogram::in_words() const {
  if (depths_ == 0) return "no pixel has a depth";
  return fmt::format(
      "{:.0f} % of the pixels have a depth, half of them from {:.2f} to {:.2f} m, nearly all from "
      "{:.2f} to {:.2f} m",
      100 * filled(), quantile(0.25), quantile(0.75), quantile(0.02), quantile(0.98));
}

Plausibility::Plausibility(const RgbdCalibration& calibration) : registration_(calibration) {}

void Plausibility::add(const RgbdFrame& frame) {
  depths_.add(frame.depth);
  const RegisteredDepth depth = registration_(frame);
  edges_.add(frame, depth);
  if (registration_.calibration().has_mount) add_surfaces(depth);
  ++frames_;
}

void Plausibility::add_surfaces(const RegisteredDepth& depth) {
  const int step = std::max(1, depth.points.cols / 80);
  const cv::Mat normals = estimate_normals(depth, step);
  const Eigen::Isometry3f T_robot_camera = registration_.calibration().T_robot_camera.cast<float>();
  for (int row = 0; row < normals.rows; ++row)
    for (int column = 0; column < normals.cols; ++column) {
      const cv::Vec3f& n = normals.at<cv::Vec3f>(row, column);
      const cv::Vec3f& p = depth.points.at<cv::Vec3f>(row * step, column * step);
      if (!std::isfinite(n[0]) || !std::isfinite(p[0])) continue;
      const float up = T_robot_camera.linear().row(2) * Eigen::Vector3f(n[0], n[1], n[2]);
      const float height = (T_robot_camera * Eigen::Vector3f(p[0], p[1], p[2])).z();
      ++surfaces_;
      below_ += height < below_floor ? 1 : 0;
      const bool level = std::abs(up) > std::cos(within), upright = std::abs(up) < std::sin(within);
      aligned_ += level || upright ? 1 : 0;
      if (up > std::cos(within)) level_heights_.push_back(height);
    }
}

std::string swapped_sides(const CameraModel& camera, const std::string& name) {
  const double w = camera.width, h = camera.height;
  const auto off = [](double centre, double side) { return std::abs(centre - side / 2) / side; };
  const bool fits = off(camera.cx, w) < 0.13 && off(camera.cy, h) < 0.13;
  const bool fits_swapped = off(camera.cx, h) < 0.13 && off(camera.cy, w) < 0.13;
  if (fits || !fits_swapped) return "";
  return fmt::format(
      "{}: width {} and height {} look swapped, since cx {:.1f} and cy {:.1f} are the middle of an "
      "image of {} x {}",
      name, camera.width, camera.height, camera.cx, camera.cy, camera.height, camera.width);
}

std::vector<std::string> Plausibility::findings() const {
  std::vector<std::string> found;
  check_proportions(found);
  if (frames_ == 0) return found;
  const std::size_t before = found.size();
  check_depths(found);
  if (found.size() > before) return found;  // with wrong depths nothing stands where it is
  check_mount(found);
  check_edges(found);
  return found;
}

void Plausibility::check_proportions(std::vector<std::string>& found) const {
  const RgbdCalibration& c = registration_.calibration();
  for (const std::string& text : {swapped_sides(c.colour, "colour camera"),
                                  c.depth_registered ? "" : swapped_sides(c.depth, "depth camera")})
    if (!text.empty()) found.push_back(text);
}

void Plausibility::check_depths(std::vector<std::string>& found) const {
  const RgbdCalibration& c = registration_.calibration();
  if (depths_.filled() < least_filled) {
    found.push_back("depth images are nearly empty: " + depths_.in_words());
    return;
  }
  const double outside = 1 - depths_.share_between(c.depth_min, c.depth_max);
  std::string text;
  if (outside > most_outside)
    text = fmt::format("{:.0f} % lie outside of the sensor's {} to {} m", 100 * outside, c.depth_min,
                       c.depth_max);
  else if (depths_.quantile(0.02) > all_far)
    text = fmt::format("hardly anything is nearer than {:.1f} m", depths_.quantile(0.02));
  else if (depths_.quantile(0.98) < all_near)
    text = fmt::format("hardly anything is farther than {:.2f} m", depths_.quantile(0.98));
  else
    return;
  text = "depth: " + text + " (" + depths_.in_words() + ")";
  for (const double mistake : usual_mistakes) {
    const double median = depths_.quantile(0.5) / mistake;
    if (median < usual_near || median > usual_far ||
        depths_.share_between(mistake * c.depth_min, mistake * c.depth_max) < 1 - most_outside / 2)
      continue;
    text += fmt::format("; is the depth scale wrong by {:g}? Then the median is {:.2f} m", mistake, median);
    break;
  }
  found.push_back(text);
}

// The order matters: what is seen far below the floor may be a wrong scale with a right mount.
void Plausibility::check_mount(std::vector<std::string>& found) const {
  if (surfaces_ < static_cast<std::int64_t>(least_surfaces)) return;
  const RgbdCalibration& c = registration_.calibration();
  const double aligned = static_cast<double>(aligned_) / static_cast<double>(surfaces_);
  const double below = static_cast<double>(below_) / static_cast<double>(surfaces_);
  const Eigen::Vector3d t = c.T_robot_camera.translation();
  if (t.norm() > 20) {
    found.push_back(
        fmt::format("mount: the camera sits {:.0f} m from the robot's middle; are millimetres given "
                    "for metres? Then the translation is [{:.3f}, {:.3f}, {:.3f}]",
                    t.norm(), 1e-3 * t.x(), 1e-3 * t.y(), 1e-3 * t.z()));
    return;
  }
  const bool tilted = aligned < least_aligned;
  if (!tilted && below < most_below) return;
  std::string text = fmt::format(
      "mount: {:.0f} % of the surfaces stand upright or lie level (in rooms most do), {:.0f} % lie below "
      "the floor",
      100 * aligned, 100 * below);
  std::vector<float> heights = level_heights_;
  if (!tilted && heights.size() > least_surfaces / 20) {
    const auto median = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), median, heights.end());
    const double distance = t.z() - static_cast<double>(*median);
    text += fmt::format("; the floor is seen {:.2f} m below the camera, the mount says {:.2f} m: ", distance,
                        t.z());
    text += t.z() > 0
                ? fmt::format("is the depth scale wrong by {:.2g}, or the mount's height?", distance / t.z())
                : "is the mount's height right, from the floor?";
  } else {
    text +=
        "; is rpy in radians (a head that looks down by 20 degrees: [0, 0.349, 0]), and x forward, y left, z "
        "up?";
  }
  found.push_back(text);
}

void Plausibility::check_edges(std::vector<std::string>& found) const {
  const RgbdCalibration& c = registration_.calibration();
  const EdgeOffset::Best best = edges_.best();
  const double shift = std::hypot(best.right, best.down) / c.colour.width;
  const bool moved = shift > least_shift || std::abs(best.scale - 1) > least_scale;
  if (edges_.edge_points() < least_edges || !moved || best.gain < least_gain ||
      best.contrast < least_contrast)
    return;
  found.push_back(fmt::format(
      "depth and colour: edges of depth fit the edges of colour when moved by {:+.0f}, {:+.0f} pixels and "
      "scaled by "
      "{:.2f}; {}",
      best.right, best.down, best.scale,
      c.depth_registered
          ? "is the depth image not registered to the colour camera? Then depth_registered is false, "
            "with depth and colour_depth"
          : "is it registered already (depth_registered: true), or colour_depth the wrong way round "
            "(it maps depth's points to colour's)?"));
}

}  // namespace lcmslam

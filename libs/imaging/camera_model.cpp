#include <lcmslam/imaging/camera_model.hpp>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

// Brown-Conrady with a rational radial part:
//   x_d = x * f(r^2) + 2 p1 x y + p2 (r^2 + 2 x^2),   f = (1 + k1 s + k2 s^2 + k3 s^3)
//   y_d = y * f(r^2) + p1 (r^2 + 2 y^2) + 2 p2 x y        / (1 + k4 s + k5 s^2 + k6 s^3),   s = r^2
struct Lens {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;

  explicit Lens(const std::vector<double>& d) {
    if (d.size() >= 4) k1 = d[0], k2 = d[1], p1 = d[2], p2 = d[3];
    if (d.size() >= 5) k3 = d[4];
    if (d.size() >= 8) k4 = d[5], k5 = d[6], k6 = d[7];
  }

  // Radial factor f and its derivative by s.
  void radial(double s, double& f, double& df) const {
    const double numerator = 1 + s * (k1 + s * (k2 + s * k3));
    const double denominator = 1 + s * (k4 + s * (k5 + s * k6));
    f = numerator / denominator;
    const double dn = k1 + s * (2 * k2 + s * 3 * k3);
    const double dd = k4 + s * (2 * k5 + s * 3 * k6);
    df = (dn - f * dd) / denominator;
  }

  // Distorted position; false where the radial curve has folded back, i.e. where a point far outside
  // the lens' view would land inside the image.
  bool distort(double x, double y, double& xd, double& yd) const {
    const double s = x * x + y * y;
    double f = 1;
    double df = 0;
    radial(s, f, df);
    xd = x * f + 2 * p1 * x * y + p2 * (s + 2 * x * x);
    yd = y * f + p1 * (s + 2 * y * y) + 2 * p2 * x * y;
    return f > 0 && f + 2 * s * df > 0;
  }

  // A step of Newton's method with the exact Jacobian towards the inverse of (xd, yd).
  struct Step {
    double error, determinant, x, y;  // at (x, y) that it begins with; where it leads
    bool in_view;

    bool arrived() const { return error < 1e-12; }
    bool possible() const {  // without branches, for step_row
      return (std::abs(determinant) > 1e-9) & (std::abs(x) < 1e3) & (std::abs(y) < 1e3);
    }
  };
  __attribute__((always_inline)) Step step(double x, double y, double xd, double yd) const {
    const double s = x * x + y * y;
    double f = 1;
    double df = 0;
    radial(s, f, df);
    const double ex = x * f + 2 * p1 * x * y + p2 * (s + 2 * x * x) - xd;
    const double ey = y * f + p1 * (s + 2 * y * y) + 2 * p2 * x * y - yd;
    const double a = f + 2 * x * x * df + 2 * p1 * y + 6 * p2 * x;
    const double b = 2 * x * y * df + 2 * p1 * x + 2 * p2 * y;  // the Jacobian is symmetric
    const double d = f + 2 * y * y * df + 6 * p1 * y + 2 * p2 * x;
    const double determinant = a * d - b * b;
    const bool in_view = (f > 0) & (f + 2 * s * df > 0);
    return {std::abs(ex) + std::abs(ey), determinant, x - (d * ex - b * ey) / determinant,
            y - (a * ey - b * ex) / determinant, in_view};
  }

  static constexpr int most_steps = 50;

  // Inverse, from the distorted position.
  bool undistort(double xd, double yd, double& x, double& y) const {
    x = xd;
    y = yd;
    for (int i = 0; i < most_steps; ++i) {
      const Step next = step(x, y, xd, yd);
      if (next.arrived()) return next.in_view;
      if (!next.possible()) return false;
      x = next.x;
      y = next.y;
    }
    return false;
  }
};

constexpr double moving = 0, arrived = 1, lost = 2;  // as wide as what they stand beside

// A step of n points; those that have arrived rest.
LCMSLAM_VECTORISED(step_row,
                   (const Lens& lens, const double* __restrict xd, double yd, int n, double* __restrict x,
                    double* __restrict y, double* __restrict state),
                   (lens, xd, yd, n, x, y, state)) {
  const Lens by_value = lens;
  for (int u = 0; u < n; ++u) {
    const Lens::Step next = by_value.step(x[u], y[u], xd[u], yd);
    const double stays = next.in_view ? arrived : lost, goes = next.possible() ? moving : lost;
    const double before = state[u], after = next.arrived() ? stays : goes;
    state[u] = before == moving ? after : before;
    x[u] = state[u] == moving ? next.x : x[u];
    y[u] = state[u] == moving ? next.y : y[u];
  }
}

[[noreturn]] void refuse(const std::string& name, const std::string& value, double is, const char* right) {
  std::ostringstream message;
  message << name << "." << value << " is " << is << ": " << right;
  throw std::invalid_argument(message.str());
}

}  // namespace

std::optional<Eigen::Vector2d> CameraModel::project(const Eigen::Vector3d& point) const {
  if (!(point.z() > 1e-9)) return std::nullopt;
  double x = point.x() / point.z();
  double y = point.y() / point.z();
  if (!distortion.empty()) {
    double xd = 0;
    double yd = 0;
    if (!Lens(distortion).distort(x, y, xd, yd)) return std::nullopt;
    x = xd;
    y = yd;
  }
  return Eigen::Vector2d(fx * x + cx, fy * y + cy);
}

Eigen::Vector3d CameraModel::ray(const Eigen::Vector2d& pixel) const {
  const double xd = (pixel.x() - cx) / fx;
  const double yd = (pixel.y() - cy) / fy;
  if (distortion.empty()) return {xd, yd, 1};
  double x = 0;
  double y = 0;
  if (!Lens(distortion).undistort(xd, yd, x, y))
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(), 1};
  return {x, y, 1};
}

void ray_row(const CameraModel& camera, int row, double* x, double* y) {
  std::vector<double> xd(static_cast<std::size_t>(camera.width));
  const double yd = (row - camera.cy) / camera.fy;
  for (std::size_t u = 0; u < xd.size(); ++u) xd[u] = (static_cast<double>(u) - camera.cx) / camera.fx;
  std::copy(xd.begin(), xd.end(), x);
  std::fill_n(y, xd.size(), yd);
  if (camera.distortion.empty()) return;
  std::vector<double> state(xd.size(), moving);
  const auto anyone = [&](double is) { return std::find(state.begin(), state.end(), is) != state.end(); };
  for (int i = 0; i < Lens::most_steps && anyone(moving); ++i)
    step_row(Lens(camera.distortion), xd.data(), yd, camera.width, x, y, state.data());
  for (std::size_t u = 0; u < state.size(); ++u)
    if (state[u] != arrived) x[u] = y[u] = std::numeric_limits<double>::quiet_NaN();
}

Eigen::Vector2d CameraModel::undistort(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector3d direction = ray(pixel);
  return {fx * direction.x() + cx, fy * direction.y() + cy};
}

CameraModel CameraModel::scaled(double factor) const {
  CameraModel other = *this;
  other.width = static_cast<int>(std::lround(width * factor));
  other.height = static_cast<int>(std::lround(height * factor));
  other.fx = fx * factor;
  other.fy = fy * factor;
  other.cx = (cx + 0.5) * factor - 0.5;
  other.cy = (cy + 0.5) * factor - 0.5;
  return other;
}

void CameraModel::check(const std::string& name) const {
  if (width < 1 || width > 8192) refuse(name, "width", width, "must be 1 to 8192 pixels");
  if (height < 1 || height > 8192) refuse(name, "height", height, "must be 1 to 8192 pixels");
  if (static_cast<std::int64_t>(width) * height > max_image_pixels)
    refuse(name, "width", width, "times height must be at most 32 Mpixel");
  if (!(fx > 0 && fx < 1e6)) refuse(name, "fx", fx, "must be above 0 pixels");
  if (!(fy > 0 && fy < 1e6)) refuse(name, "fy", fy, "must be above 0 pixels");
  if (!(cx > -width && cx < 2 * width)) refuse(name, "cx", cx, "must be near the image's middle, in pixels");
  if (!(cy > -height && cy < 2 * height))
    refuse(name, "cy", cy, "must be near the image's middle, in pixels");
  const std::size_t n = distortion.size();
  if (n != 0 && n != 4 && n != 5 && n != 8)
    refuse(name, "distortion", static_cast<double>(n), "coefficients; must be 0, 4, 5 or 8 of them");
  for (double k : distortion)
    if (!std::isfinite(k)) refuse(name, "distortion", k, "must be finite");
  // A lens model that cannot be inverted inside the image is a wrong calibration.
  constexpr int samples = 16;
  for (int i = 0; i <= samples; ++i) {
    for (int j = 0; j <= samples; ++j) {
      const Eigen::Vector2d pixel((width - 1.0) * i / samples, (height - 1.0) * j / samples);
      if (!ray(pixel).allFinite()) {
        std::ostringstream message;
        message << name << ".distortion folds at pixel (" << pixel.x() << ", " << pixel.y()
                << "): check the coefficients' order k1 k2 p1 p2 k3 and their signs";
        throw std::invalid_argument(message.str());
      }
    }
  }
}

namespace {

cv::Mat make_ray_table(const CameraModel& camera) {
  cv::Mat table(camera.height, camera.width, CV_32FC2);
  std::vector<double> x(static_cast<std::size_t>(camera.width)), y(x.size());
  for (int v = 0; v < camera.height; ++v) {
    ray_row(camera, v, x.data(), y.data());
    auto* row = table.ptr<cv::Vec2f>(v);
    for (std::size_t u = 0; u < x.size(); ++u) row[u] = {static_cast<float>(x[u]), static_cast<float>(y[u])};
  }
  return table;
}

}  // namespace

// Half a dozen parts of a process want the same table, and a distorted VGA image takes a while.
cv::Mat ray_table(const CameraModel& camera) {
  constexpr std::size_t kept = 4;  // cameras
  static std::mutex mutex;
  static std::deque<std::pair<CameraModel, cv::Mat>> tables;
  const std::lock_guard<std::mutex> lock(mutex);
  for (const auto& [known, table] : tables)
    if (known == camera) return table;
  tables.emplace_back(camera, make_ray_table(camera));
  if (tables.size() > kept) tables.pop_front();
  return tables.back().second;
}

}  // namespace lcmslam

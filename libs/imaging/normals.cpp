#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "imaging/registration.hpp"

namespace lcmslam {
namespace {

// The inverse depth of a plane n . p = 1 is linear in the ray: 1/z = n . (x, y, 1). Measured inverse
// depths around a pixel therefore give n by linear least squares in two unknowns, a and b, after
// centring:  1/z = c + a x + b y,  n = (a, b, c).
struct InverseDepth {
  float x, y, q;  // ray and 1 / z
};

cv::Mat inverse_depths(const cv::Mat& points) {
  cv::Mat result(points.size(), CV_32FC3);
  for (int v = 0; v < points.rows; ++v) {
    const auto* point = points.ptr<cv::Vec3f>(v);
    auto* out = result.ptr<InverseDepth>(v);
    for (int u = 0; u < points.cols; ++u) {
      const float q = 1.0f / point[u][2];
      out[u] = {point[u][0] * q, point[u][1] * q, q};
    }
  }
  return result;
}

constexpr int reach = 2;                    // samples on either side: 5 x 5
constexpr float steepest = 5;               // depth over lateral distance of a surface still worth fitting
constexpr float wanted_uncertainty = 0.1f;  // rad
constexpr float greatest_uncertainty = 0.3f;
constexpr int greatest_stride = 6;
constexpr int fewest_samples = 10;

// Pixels between samples: 25 of them at stride d leave the slope uncertain by sigma / (sqrt(50) d z pitch).
int sample_stride(float sigma, float z, float pitch) {
  const float stride = sigma / (wanted_uncertainty * 7.07f * z * pitch);
  return std::clamp(static_cast<int>(std::lround(stride)), 1, greatest_stride);
}

class PlaneFit {
 public:
  void add(float x, float y, float q) {
    n_ += 1, x_ += x, y_ += y, q_ += q;
    xx_ += x * x, xy_ += x * y, yy_ += y * y, xq_ += x * q, yq_ += y * q, qq_ += q * q;
  }

  // Fits and returns (a, b, value at the origin); false when there is too little.
  bool solve(float sigma_q, float& a, float& b, float& c) const {
    if (n_ < fewest_samples) return false;
    const float xx = xx_ - x_ * x_ / n_;
    const float xy = xy_ - x_ * y_ / n_;
    const float yy = yy_ - y_ * y_ / n_;
    const float xq = xq_ - x_ * q_ / n_;
    const float yq = yq_ - y_ * q_ / n_;
    const float determinant = xx * yy - xy * xy;
    // A neighbourhood on one line only determines no plane.
    if (!(determinant > 0.02f * (xx + yy) * (xx + yy))) return false;
    a = (yy * xq - xy * yq) / determinant;
    b = (xx * yq - xy * xq) / determinant;
    c = (q_ - a * x_ - b * y_) / n_;
    const float residual = (qq_ - q_ * q_ / n_) - a * xq - b * yq;
    if (residual > 9 * sigma_q * sigma_q * n_) return false;  // an edge or a corner, not a plane
    variance_ = sigma_q * sigma_q * (xx + yy) / determinant;
    return true;
  }

  float variance() const { return variance_; }  // of (a, b) together

 private:
  float n_ = 0, x_ = 0, y_ = 0, q_ = 0, xx_ = 0, xy_ = 0, yy_ = 0, xq_ = 0, yq_ = 0, qq_ = 0;
  mutable float variance_ = 0;
};

cv::Vec3f normal_at(const cv::Mat& image, int u, int v, float sigma, float pitch) {
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  const cv::Vec3f unknown = cv::Vec3f::all(nothing);
  const InverseDepth centre = image.ptr<InverseDepth>(v)[u];
  if (!(centre.q > 0)) return unknown;
  const float z = 1 / centre.q;
  const int stride = sample_stride(sigma, z, pitch);
  const float sigma_q = sigma * centre.q * centre.q;
  const float noise_gate = 4.2f * sigma_q;  // three standard deviations of a difference
  const float slope_gate = steepest * pitch * static_cast<float>(stride) * centre.q;

  PlaneFit fit;
  for (int j = -reach; j <= reach; ++j) {
    const int row = v + j * stride;
    if (row < 0 || row >= image.rows) continue;
    const auto* samples = image.ptr<InverseDepth>(row);
    for (int i = -reach; i <= reach; ++i) {
      const int column = u + i * stride;
      if (column < 0 || column >= image.cols) continue;
      const InverseDepth& sample = samples[column];
      const float dq = sample.q - centre.q;
      const float distance = static_cast<float>(std::max(std::abs(i), std::abs(j)));
      if (std::abs(dq) <= noise_gate + slope_gate * distance)  // false for NaN
        fit.add(sample.x - centre.x, sample.y - centre.y, dq);
    }
  }
  float a = 0;
  float b = 0;
  float c = 0;
  if (!fit.solve(sigma_q, a, b, c)) return unknown;

  const float nx = a;
  const float ny = b;
  const float nz = centre.q + c - a * centre.x - b * centre.y;
  const float length = std::sqrt(nx * nx + ny * ny + nz * nz);
  if (!(length > 0) || fit.variance() > greatest_uncertainty * greatest_uncertainty * length * length)
    return unknown;
  return cv::Vec3f(-nx, -ny, -nz) / length;
}

}  // namespace

cv::Mat estimate_normals(const RegisteredDepth& registered, int step) {
  if (step < 1) throw std::invalid_argument("estimate_normals: step must be at least 1");
  const cv::Mat image = inverse_depths(registered.points);
  cv::Mat normals((image.rows + step - 1) / step, (image.cols + step - 1) / step, CV_32FC3);
  for (int v = 0; v < image.rows; v += step) {
    const auto* sigma = registered.sigma.ptr<float>(v);
    auto* normal = normals.ptr<cv::Vec3f>(v / step);
    for (int u = 0; u < image.cols; u += step)
      normal[u / step] = normal_at(image, u, v, sigma[u], registered.pitch);
  }
  return normals;
}

}  // namespace lcmslam

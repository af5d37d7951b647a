#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/inverse_depths.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

// Two unknowns, a and b, after centring:  1/z = c + a x + b y,  n = (a, b, c).

constexpr int reach = 2;                    // samples on either side: 5 x 5
constexpr float steepest = 5;               // depth over lateral distance of a surface still worth fitting
constexpr float wanted_uncertainty = 0.1f;  // rad
constexpr float greatest_uncertainty = 0.3f;
constexpr int greatest_stride = 6;
constexpr float fewest_samples = 10;
constexpr int border = reach * greatest_stride;  // pixels without depth, so that nobody asks where images end
constexpr int lanes = 8;                         // pixels that are fitted at once

LCMSLAM_VECTORISED(invert_row, (const float* point, int columns, float* x, float* y, float* q),
                   (point, columns, x, y, q)) {
  for (int u = 0; u < columns; ++u) {
    const float inverse = 1.0f / point[3 * u + 2];
    x[u] = point[3 * u] * inverse;
    y[u] = point[3 * u + 1] * inverse;
    q[u] = inverse;
  }
}

/// Some pixels of a row, one a lane.
struct Pixels {
  std::ptrdiff_t at[lanes];
  bool neighbours;  // at grows by one from lane to lane
  float sigma[lanes];
  float nx[lanes], ny[lanes], nz[lanes];  // the results, NaN where unknown
};

// Each lane sees its own 25 samples; those beyond an edge or without depth add zeros.
LCMSLAM_VECTORISED(fit_planes,
                   (const float* image_x, const float* image_y, const float* image_q,
                    std::ptrdiff_t image_pitch, float pixel_pitch, Pixels& pixels),
                   (image_x, image_y, image_q, image_pitch, pixel_pitch, pixels)) {
  float x0[lanes], y0[lanes], q0[lanes], sigma_q[lanes], noise_gate[lanes], slope_gate[lanes];
  std::ptrdiff_t stride[lanes];
  float n[lanes] = {}, x[lanes] = {}, y[lanes] = {}, q[lanes] = {};
  float xx[lanes] = {}, xy[lanes] = {}, yy[lanes] = {}, xq[lanes] = {}, yq[lanes] = {}, qq[lanes] = {};
  for (int l = 0; l < lanes; ++l) {
    x0[l] = image_x[pixels.at[l]];
    y0[l] = image_y[pixels.at[l]];
    q0[l] = image_q[pixels.at[l]];
  }
  for (int l = 0; l < lanes; ++l) {
    // 25 samples at stride d leave the slope uncertain by sigma / (sqrt(50) d z pitch).
    const float z = 1 / q0[l];
    const float wanted = pixels.sigma[l] / (wanted_uncertainty * 7.07f * z * pixel_pitch);
    const float chosen = wanted > 1 ? (wanted < greatest_stride ? wanted : greatest_stride) : 1;
    const int pixels_apart = static_cast<int>(chosen + 0.5f);
    stride[l] = q0[l] > 0 ? pixels_apart : 0;  // without depth: no matter
    sigma_q[l] = pixels.sigma[l] * q0[l] * q0[l];
    noise_gate[l] = 4.2f * sigma_q[l];  // three standard deviations of a difference
    slope_gate[l] = steepest * pixel_pitch * static_cast<float>(pixels_apart) * q0[l];
  }
  std::ptrdiff_t common = 0;
  for (int l = 0; l < lanes; ++l) common = std::max(common, stride[l]);
  bool together = pixels.neighbours;  // the lanes' samples lie side by side
  for (int l = 0; l < lanes; ++l) together = together && (stride[l] == common || stride[l] == 0);
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i) {
      const auto distance = static_cast<float>(std::max(std::abs(i), std::abs(j)));
      const std::ptrdiff_t first = pixels.at[0] + common * (j * image_pitch + i);
      const float *sample_x = image_x + first, *sample_y = image_y + first, *sample_q = image_q + first;
      float apart_x[lanes], apart_y[lanes], apart_q[lanes];
      if (!together) {
        for (int l = 0; l < lanes; ++l) {
          const std::ptrdiff_t at = pixels.at[l] + stride[l] * (j * image_pitch + i);
          apart_x[l] = image_x[at];
          apart_y[l] = image_y[at];
          apart_q[l] = image_q[at];
        }
        sample_x = apart_x;
        sample_y = apart_y;
        sample_q = apart_q;
      }
      for (int l = 0; l < lanes; ++l) {
        const float to_x = sample_x[l] - x0[l], to_y = sample_y[l] - y0[l], to_q = sample_q[l] - q0[l];
        const float gate = noise_gate[l] + slope_gate[l] * distance;
        const float one = std::abs(to_q) <= gate ? 1.0f : 0.0f;  // NaN: not
        const float dx = one > 0 ? to_x : 0.0f;
        const float dy = one > 0 ? to_y : 0.0f;
        const float dq = one > 0 ? to_q : 0.0f;
        n[l] += one;
        x[l] += dx;
        y[l] += dy;
        q[l] += dq;
        xx[l] += dx * dx;
        xy[l] += dx * dy;
        yy[l] += dy * dy;
        xq[l] += dx * dq;
        yq[l] += dy * dq;
        qq[l] += dq * dq;
      }
    }
  for (int l = 0; l < lanes; ++l) {
    const float cxx = xx[l] - x[l] * x[l] / n[l];
    const float cxy = xy[l] - x[l] * y[l] / n[l];
    const float cyy = yy[l] - y[l] * y[l] / n[l];
    const float cxq = xq[l] - x[l] * q[l] / n[l];
    const float cyq = yq[l] - y[l] * q[l] / n[l];
    const float determinant = cxx * cyy - cxy * cxy;
    const float a = (cyy * cxq - cxy * cyq) / determinant;
    const float b = (cxx * cyq - cxy * cxq) / determinant;
    const float c = (q[l] - a * x[l] - b * y[l]) / n[l];
    const float residual = (qq[l] - q[l] * q[l] / n[l]) - a * cxq - b * cyq;
    const float variance = sigma_q[l] * sigma_q[l] * (cxx + cyy) / determinant;  // of (a, b) together
    const float nz = q0[l] + c - a * x0[l] - b * y0[l];
    const float length = std::sqrt(a * a + b * b + nz * nz);
    // A neighbourhood on one line only determines no plane; an edge or a corner is none.
    const bool known = (q0[l] > 0) & (n[l] >= fewest_samples) &
                       (determinant > 0.02f * (cxx + cyy) * (cxx + cyy)) &
                       !(residual > 9 * sigma_q[l] * sigma_q[l] * n[l]) & (length > 0) &
                       !(variance > greatest_uncertainty * greatest_uncertainty * length * length);
    const float unknown = std::numeric_limits<float>::quiet_NaN();
    const float towards_camera = -(1.0f / length);
    pixels.nx[l] = known ? a * towards_camera : unknown;
    pixels.ny[l] = known ? b * towards_camera : unknown;
    pixels.nz[l] = known ? nz * towards_camera : unknown;
  }
}

}  // namespace

InverseDepths::InverseDepths(const cv::Size& size) {
  const cv::Size with_border = size + cv::Size(2 * border, 2 * border);
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  pitch = with_border.width;
  for (cv::Mat_<float>* plane : {&x, &y, &q}) {
    plane->create(with_border);
    for (int v = 0; v < with_border.height; ++v) {
      float* row = plane->ptr<float>(v);
      const bool inside = v >= border && v < border + size.height;
      std::fill(row, row + (inside ? border : with_border.width), nothing);
      std::fill(row + with_border.width - border, row + with_border.width, nothing);
    }
  }
}

std::ptrdiff_t InverseDepths::at(int v, int u) const {
  return (v + border) * pitch + u + border;
}

void InverseDepths::set_row(int v, const float* point, int columns) {
  invert_row(point, columns, x.ptr<float>() + at(v, 0), y.ptr<float>() + at(v, 0), q.ptr<float>() + at(v, 0));
}

cv::Mat fit_normals(const InverseDepths& image, const cv::Mat& sigma, int step, float pixel_pitch) {
  cv::Mat normals(sigma.size(), CV_32FC3);
  for (int v = 0; v < normals.rows; ++v) {
    auto* normal = normals.ptr<cv::Vec3f>(v);
    for (int first = 0; first < normals.cols; first += lanes) {
      Pixels pixels;
      pixels.neighbours = step == 1 && first + lanes <= normals.cols;
      for (int l = 0; l < lanes; ++l) {  // beyond the row's end its last pixel again
        const int u = std::min(first + l, normals.cols - 1);
        pixels.at[l] = image.at(step * v, step * u);
        pixels.sigma[l] = sigma.at<float>(v, u);
      }
      fit_planes(image.x.ptr<float>(), image.y.ptr<float>(), image.q.ptr<float>(), image.pitch, pixel_pitch,
                 pixels);
      for (int l = 0; l < std::min(lanes, normals.cols - first); ++l)
        normal[first + l] = {pixels.nx[l], pixels.ny[l], pixels.nz[l]};
    }
  }
  return normals;
}

cv::Mat estimate_normals(const RegisteredDepth& registered, int step) {
  if (step < 1) throw std::invalid_argument("estimate_normals: step must be at least 1");
  const cv::Size size = registered.points.size();
  InverseDepths image(size);
  for (int v = 0; v < size.height; ++v) image.set_row(v, registered.points.ptr<float>(v), size.width);
  cv::Mat_<float> sigma((size.height + step - 1) / step, (size.width + step - 1) / step);
  for (int v = 0; v < sigma.rows; ++v)
    for (int u = 0; u < sigma.cols; ++u) sigma(v, u) = registered.sigma.at<float>(step * v, step * u);
  return fit_normals(image, sigma, step, registered.pitch);
}

}  // namespace lcmslam

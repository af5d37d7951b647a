#include "surf/patch.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>

namespace lcmslam {
namespace {

int box_side(float pitch) {
  return std::max(1, static_cast<int>(std::lround(pitch)));
}

// Mean of the box [x0, x0 + side) x [y0, y0 + side), cut to the image; at least one pixel remains.
float box_mean(const IntegralImage& integral, int x0, int y0, int side) {
  const int left = std::clamp(x0, 0, integral.width() - 1);
  const int top = std::clamp(y0, 0, integral.height() - 1);
  const int right = std::clamp(x0 + side, left + 1, integral.width());
  const int bottom = std::clamp(y0 + side, top + 1, integral.height());
  return static_cast<float>(integral.box(left, top, right, bottom)) /
         static_cast<float>((right - left) * (bottom - top));
}

}  // namespace

void PatchSampler::prepare(const IntegralImage& integral, const std::vector<float>& pitches) {
  integral_ = &integral;
  bool needed[max_filtered_side + 1] = {};
  for (float pitch : pitches)
    if (box_side(pitch) <= max_filtered_side) needed[box_side(pitch)] = true;
  for (int side = 1; side <= max_filtered_side; ++side)
    if (needed[side]) filter(side);
}

// Pixel (x, y) of the filtered image is the mean of the box that begins at x - side / 2, y - side / 2.
void PatchSampler::filter(int side) {
  const int width = integral_->width(), height = integral_->height(), before = side / 2;
  auto& image = filtered_[side];
  image.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const int first = std::min(before, width), last = std::max(first, width - side + before + 1);
  cv::parallel_for_(cv::Range(0, height), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      float* out = image.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      const int y0 = std::max(0, y - before), y1 = std::clamp(y - before + side, y0 + 1, height);
      const std::uint32_t* top = integral_->row(y0);
      const std::uint32_t* bottom = integral_->row(y1);
      const float inverse_area = 1.f / static_cast<float>(side * (y1 - y0));
      for (int x = 0; x < first; ++x) out[x] = box_mean(*integral_, x - before, y - before, side);
      for (int x = first; x < last; ++x) {
        const int x0 = x - before;
        const std::uint32_t sum = (bottom[x0 + side] - bottom[x0]) - (top[x0 + side] - top[x0]);
        out[x] = static_cast<float>(static_cast<std::int32_t>(sum)) * inverse_area;
      }
      for (int x = last; x < width; ++x) out[x] = box_mean(*integral_, x - before, y - before, side);
    }
  });
}

void PatchSampler::sample(const PatchPose& pose, int n, float* patch) const {
  const int side = box_side(pose.pitch);
  if (side <= max_filtered_side)
    sample_filtered(pose, n, side, patch);
  else
    sample_boxes(pose, n, side, patch);
}

void PatchSampler::sample_filtered(const PatchPose& pose, int n, int side, float* patch) const {
  const int width = integral_->width(), height = integral_->height();
  const float* image = filtered_[side].data();
  const float step_x = pose.cosine * pose.pitch, step_y = pose.sine * pose.pitch;
  const float half = 0.5f * static_cast<float>(n - 1);
  const float box_centre = side % 2 == 0 ? 0.5f : 0.f;  // the box of pixel x is centred on x - box_centre
  const float centre_x = pose.x + box_centre, centre_y = pose.y + box_centre;
  const float reach = half * (std::abs(step_x) + std::abs(step_y)) + 1.f;
  const bool inside = centre_x - reach >= 0 && centre_x + reach <= static_cast<float>(width - 1) &&
                      centre_y - reach >= 0 && centre_y + reach <= static_cast<float>(height - 1);
  for (int j = 0; j < n; ++j) {
    const float v = static_cast<float>(j) - half;
    const float row_x = centre_x - v * step_y, row_y = centre_y + v * step_x;
    for (int i = 0; i < n; ++i) {
      const float u = static_cast<float>(i) - half;
      float x = row_x + u * step_x, y = row_y + u * step_y;
      int next_column = 1, next_row = width;
      if (!inside) {
        x = std::clamp(x, 0.f, static_cast<float>(width - 1));
        y = std::clamp(y, 0.f, static_cast<float>(height - 1));
      }
      const int column = static_cast<int>(x), row = static_cast<int>(y);
      if (!inside) {
        if (column + 1 >= width) next_column = 0;
        if (row + 1 >= height) next_row = 0;
      }
      const float fraction_x = x - static_cast<float>(column), fraction_y = y - static_cast<float>(row);
      const float* upper = image + static_cast<std::ptrdiff_t>(row) * width + column;
      const float* lower = upper + next_row;
      const float above = upper[0] + fraction_x * (upper[next_column] - upper[0]);
      const float below = lower[0] + fraction_x * (lower[next_column] - lower[0]);
      patch[j * n + i] = above + fraction_y * (below - above);
    }
  }
}

void PatchSampler::sample_boxes(const PatchPose& pose, int n, int side, float* patch) const {
  const float step_x = pose.cosine * pose.pitch, step_y = pose.sine * pose.pitch;
  const float half = 0.5f * static_cast<float>(n - 1);
  const float to_corner = 1.f - 0.5f * static_cast<float>(side);  // + rounding to the nearest pixel
  // Far outside, the nearest border box says the same and the conversion to int stays defined.
  const auto limit_x = static_cast<float>(integral_->width() + side);
  const auto limit_y = static_cast<float>(integral_->height() + side);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const float u = static_cast<float>(i) - half, v = static_cast<float>(j) - half;
      const float x = std::clamp(pose.x + u * step_x - v * step_y + to_corner, -limit_x, limit_x);
      const float y = std::clamp(pose.y + u * step_y + v * step_x + to_corner, -limit_y, limit_y);
      patch[j * n + i] =
          box_mean(*integral_, static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)), side);
    }
}

}  // namespace lcmslam

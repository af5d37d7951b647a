#include "surf/surf.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "surf/descriptor.hpp"
#include "surf/extrema.hpp"

namespace lcmslam {
namespace {

constexpr float degrees = 57.2957795f;

void require(bool condition, const std::string& what) {
  if (!condition) throw std::invalid_argument("SURF: " + what);
}

void check(const SurfSettings& s) {
  require(std::isfinite(s.hessian_threshold) && s.hessian_threshold >= 0,
          "hessian_threshold is " + std::to_string(s.hessian_threshold) + ", must be 0 or more");
  require(s.octaves >= 1 && s.octaves <= 6, "octaves is " + std::to_string(s.octaves) + ", must be 1 to 6");
  require(s.intervals >= 3 && s.intervals <= 8,
          "intervals is " + std::to_string(s.intervals) + ", must be 3 to 8");
  const FeatureBudget& budget = s.budget;
  require(budget.max_features >= 0,
          "max_features is " + std::to_string(budget.max_features) + ", must be 0 (no limit) or more");
  require(budget.columns >= 1 && budget.columns <= 1000 && budget.rows >= 1 && budget.rows <= 1000,
          "the grid is " + std::to_string(budget.columns) + " x " + std::to_string(budget.rows) +
              ", must be 1 to 1000 each way");
  require(budget.cell_share >= 1,
          "cell_share is " + std::to_string(budget.cell_share) + ", must be 1 or more");
}

// The image itself where it is grey already, else its conversion into `buffer`.
cv::Mat to_grey(const cv::Mat& image, cv::Mat& buffer) {
  if (image.empty() || image.type() == CV_8UC1) return image;
  require(image.type() == CV_8UC3 || image.type() == CV_8UC4,
          "the image is " + cv::typeToString(image.type()) + ", must be 8-bit with 1, 3 (BGR) or 4 channels");
  cv::cvtColor(image, buffer, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return buffer;
}

void check_mask(const cv::Mat& mask, const cv::Mat& image) {
  if (mask.empty()) return;
  require(mask.type() == CV_8UC1, "the mask is " + cv::typeToString(mask.type()) + ", must be CV_8UC1");
  require(mask.size() == image.size(), "the mask is " + std::to_string(mask.cols) + "x" +
                                           std::to_string(mask.rows) + ", the image " +
                                           std::to_string(image.cols) + "x" + std::to_string(image.rows));
}

void check_provided(const std::vector<cv::KeyPoint>& keypoints) {
  for (const cv::KeyPoint& keypoint : keypoints)
    require(std::isfinite(keypoint.pt.x) && std::isfinite(keypoint.pt.y) && std::isfinite(keypoint.angle) &&
                std::isfinite(keypoint.size) && keypoint.size > 0,
            "a keypoint has no finite position and angle, or no positive size");
}

bool masked_out(const Blob& blob, const cv::Mat& mask) {
  const int x = std::clamp(static_cast<int>(std::lround(blob.x)), 0, mask.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(blob.y)), 0, mask.rows - 1);
  return mask.at<std::uint8_t>(y, x) == 0;
}

}  // namespace

Surf::Surf(const SurfSettings& settings) : settings_(settings) {
  check(settings_);
}

void Surf::set_hessian_threshold(double threshold) {
  SurfSettings changed = settings_;
  changed.hessian_threshold = threshold;
  check(changed);
  settings_ = changed;
}

void Surf::detect_blobs(const cv::Mat& mask, std::vector<cv::KeyPoint>& keypoints) {
  pyramid_.compute(integral_, settings_.octaves, settings_.intervals);
  auto blobs = find_blobs(pyramid_, integral_, static_cast<float>(settings_.hessian_threshold));
  if (!mask.empty())
    blobs.erase(
        std::remove_if(blobs.begin(), blobs.end(), [&](const Blob& b) { return masked_out(b, mask); }),
        blobs.end());
  blobs_found_ = static_cast<int>(blobs.size());
  blobs = select_blobs(std::move(blobs), settings_.budget, integral_.width(), integral_.height());
  keypoints.clear();
  keypoints.reserve(blobs.size());
  for (const Blob& b : blobs)
    keypoints.emplace_back(b.x, b.y, b.size, -1.f, b.response, b.octave, b.laplacian);
}

void Surf::detectAndCompute(cv::InputArray image_array, cv::InputArray mask_array,
                            std::vector<cv::KeyPoint>& keypoints, cv::OutputArray descriptors,
                            bool use_provided_keypoints) {
  const cv::Mat image = image_array.getMat(), mask = mask_array.getMat();
  const cv::Mat grey = to_grey(image, grey_);
  blobs_found_ = 0;
  if (grey.empty()) {
    keypoints.clear();
    if (descriptors.needed()) descriptors.release();
    return;
  }
  check_mask(mask, image);

  integral_.compute(grey);
  if (use_provided_keypoints)
    check_provided(keypoints);
  else
    detect_blobs(mask, keypoints);

  const int count = static_cast<int>(keypoints.size());
  std::vector<float> scales(keypoints.size());
  for (std::size_t k = 0; k < keypoints.size(); ++k) scales[k] = scale_of_filter(keypoints[k].size);
  sampler_.prepare(integral_, scales);

  cv::Mat rows;
  if (descriptors.needed()) {
    descriptors.create(count, 64, CV_32F);
    rows = descriptors.getMat();
  }
  cv::parallel_for_(cv::Range(0, count), [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k) {
      cv::KeyPoint& keypoint = keypoints[static_cast<std::size_t>(k)];
      const float scale = scales[static_cast<std::size_t>(k)];
      if (settings_.upright)
        keypoint.angle = 0;
      else if (keypoint.angle < 0)
        keypoint.angle = degrees * dominant_orientation(sampler_, keypoint.pt.x, keypoint.pt.y, scale);
      if (!rows.empty())
        describe(sampler_, keypoint.pt.x, keypoint.pt.y, scale, keypoint.angle / degrees, rows.ptr<float>(k));
    }
  });
}

}  // namespace lcmslam

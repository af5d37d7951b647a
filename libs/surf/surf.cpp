#include <lcmslam/surf/surf.hpp>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include <lcmslam/parallel/rows.hpp>
#include <lcmslam/settings/check.hpp>
#include <lcmslam/surf/descriptor.hpp>

namespace lcmslam {
namespace {

constexpr float degrees = 57.2957795f;

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("SURF: " + what);
}

// The image itself where it is grey already, else its conversion into `buffer`.
cv::Mat to_grey(const cv::Mat& image, cv::Mat& buffer) {
  if (image.empty() || image.type() == CV_8UC1) return image;
  if (image.type() != CV_8UC3 && image.type() != CV_8UC4)
    refuse("the image is " + cv::typeToString(image.type()) +
           ", must be 8-bit with 1, 3 (BGR) or 4 channels");
  cv::cvtColor(image, buffer, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return buffer;
}

void check_mask(const cv::Mat& mask, const cv::Mat& image) {
  if (mask.empty()) return;
  if (mask.type() != CV_8UC1) refuse("the mask is " + cv::typeToString(mask.type()) + ", must be CV_8UC1");
  if (mask.size() != image.size())
    refuse("the mask is " + std::to_string(mask.cols) + "x" + std::to_string(mask.rows) + ", the image " +
           std::to_string(image.cols) + "x" + std::to_string(image.rows));
}

void check_provided(const std::vector<cv::KeyPoint>& keypoints) {
  for (const cv::KeyPoint& k : keypoints)
    if (!std::isfinite(k.pt.x) || !std::isfinite(k.pt.y) || !std::isfinite(k.angle) ||
        !std::isfinite(k.size) || !(k.size > 0))
      refuse("a keypoint has no finite position and angle, or no positive size");
}

bool masked_out(const Blob& blob, const cv::Mat& mask) {
  const int x = std::clamp(static_cast<int>(std::lround(blob.x)), 0, mask.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(blob.y)), 0, mask.rows - 1);
  return mask.at<std::uint8_t>(y, x) == 0;
}

}  // namespace

Surf::Surf(const SurfSettings& settings) : settings_(settings) {
  check(settings_, "SURF");
}

void Surf::set_hessian_threshold(double threshold) {
  SurfSettings changed = settings_;
  changed.hessian_threshold = threshold;
  check(changed, "SURF");
  settings_ = changed;
}

void Surf::detect_blobs(const cv::Mat& mask, std::vector<cv::KeyPoint>& keypoints) {
  pyramid_.compute(integral_, settings_.octaves, settings_.intervals);
  finder_.find(pyramid_, integral_, static_cast<float>(settings_.hessian_threshold),
               static_cast<float>(settings_.edge_ratio), blobs_);
  if (!mask.empty())
    blobs_.erase(
        std::remove_if(blobs_.begin(), blobs_.end(), [&](const Blob& b) { return masked_out(b, mask); }),
        blobs_.end());
  blobs_found_ = static_cast<int>(blobs_.size());
  selection_.select(blobs_, settings_.budget, integral_.width(), integral_.height());
  keypoints.clear();
  keypoints.reserve(blobs_.size());
  for (const Blob& b : blobs_)
    keypoints.emplace_back(b.x, b.y, settings_.smooth ? unsmoothed_size(b.size) : b.size, -1.f, b.response,
                           b.octave, b.laplacian);
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

  integral_.compute(settings_.smooth ? smoother_.smooth(grey) : grey);
  if (use_provided_keypoints)
    check_provided(keypoints);
  else
    detect_blobs(mask, keypoints);

  const int count = static_cast<int>(keypoints.size());
  scales_.clear();
  pitches_.clear();
  for (const cv::KeyPoint& keypoint : keypoints) {
    scales_.push_back(scale_of_filter(settings_.smooth ? smoothed_size(keypoint.size) : keypoint.size));
    pitches_.push_back(patch_pitch * scales_.back());
  }
  sampler_.prepare(integral_, pitches_);

  cv::Mat rows;
  if (descriptors.needed()) {
    descriptors.create(count, descriptorSize(), CV_32F);
    rows = descriptors.getMat();
  }
  parallel_rows(0, count, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      cv::KeyPoint& keypoint = keypoints[static_cast<std::size_t>(k)];
      const float scale = scales_[static_cast<std::size_t>(k)];
      if (settings_.upright)
        keypoint.angle = 0;
      else if (keypoint.angle < 0)
        keypoint.angle = degrees * dominant_orientation(sampler_, keypoint.pt.x, keypoint.pt.y, scale);
      if (rows.empty()) continue;
      const auto describe_one = settings_.extended ? describe_extended : describe;
      describe_one(sampler_, keypoint.pt.x, keypoint.pt.y, scale, keypoint.angle / degrees,
                   rows.ptr<float>(k));
    }
  });
}

}  // namespace lcmslam

#pragma once
// Features with depth from a TUM RGB-D folder, straight from its files.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam::testing {

class TumRecording {
 public:
  explicit TumRecording(const std::filesystem::path& folder) : folder_(folder) {
    std::ifstream text(folder / "associations.txt");
    for (std::string line; std::getline(text, line);) {
      std::istringstream words(line);
      Pair pair;
      double depth_stamp = 0;
      if (words >> pair.stamp >> pair.colour >> depth_stamp >> pair.depth) pairs_.push_back(pair);
    }
  }

  std::size_t size() const { return pairs_.size(); }

  /// Depth is registered to colour; Kinect noise; fr1's calibration (ORIGIN.md).
  FeatureFrame features(std::size_t index) {
    const cv::Mat colour = cv::imread((folder_ / pairs_[index].colour).string(), cv::IMREAD_GRAYSCALE);
    const cv::Mat depth = cv::imread((folder_ / pairs_[index].depth).string(), cv::IMREAD_UNCHANGED);
    if (colour.empty() || depth.type() != CV_16UC1)
      throw std::runtime_error("unreadable " + pairs_[index].colour);

    FeatureFrame frame;
    frame.utime = std::llround(pairs_[index].stamp * 1e6);
    frame.width = colour.cols;
    frame.height = colour.rows;
    frame.fx = 517.3, frame.fy = 516.5, frame.cx = 318.6, frame.cy = 255.3;

    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    surf_.detectAndCompute(colour, cv::noArray(), keypoints, descriptors);
    if (keypoints.empty()) return frame;
    std::vector<cv::Point2f> pixels, ideal;
    for (const cv::KeyPoint& keypoint : keypoints) pixels.push_back(keypoint.pt);
    const cv::Matx33d K(frame.fx, 0, frame.cx, 0, frame.fy, frame.cy, 0, 0, 1);
    cv::undistortPoints(pixels, ideal, K, cv::Vec<double, 5>(0.2624, -0.9531, -0.0054, 0.0026, 1.1633),
                        cv::noArray(), K);
    for (std::size_t i = 0; i < keypoints.size(); ++i) {
      Feature feature;
      feature.x = ideal[i].x;
      feature.y = ideal[i].y;
      feature.size = keypoints[i].size;
      feature.laplacian = static_cast<std::int8_t>(keypoints[i].class_id);
      feature.descriptor = to_bytes(descriptors.ptr<float>(static_cast<int>(i)));
      set_point(depth, pixels[i], frame, feature);
      frame.features.push_back(feature);
    }
    return frame;
  }

 private:
  struct Pair {
    double stamp = 0;  // s, of the colour image
    std::string colour, depth;
  };

  // Mean depth of the 3x3 neighbours, unless one is missing or they lie on both sides of an edge.
  static void set_point(const cv::Mat& depth, const cv::Point2f& pixel, const FeatureFrame& frame,
                        Feature& feature) {
    const int u = cvRound(pixel.x), v = cvRound(pixel.y);
    if (u < 1 || v < 1 || u >= depth.cols - 1 || v >= depth.rows - 1) return;
    double low = 0, high = 0;
    const cv::Mat near = depth(cv::Rect(u - 1, v - 1, 3, 3));
    cv::minMaxLoc(near, &low, &high);
    if (low == 0 || high - low > 0.03 * low) return;
    const double z = cv::mean(near)[0] / 5000;
    feature.kind = MeasurementKind::point;
    feature.point =
        Eigen::Vector3d((feature.x - frame.cx) / frame.fx * z, (feature.y - frame.cy) / frame.fy * z, z)
            .cast<float>();
    feature.depth_sigma = static_cast<float>(0.0012 + 0.0019 * (z - 0.4) * (z - 0.4));
  }

  std::filesystem::path folder_;
  std::vector<Pair> pairs_;
  Surf surf_;
};

}  // namespace lcmslam::testing

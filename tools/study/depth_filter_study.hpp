#pragma once
// How many mixed pixels the depth filter takes out, and how many good points with them, against the
// simulation's exact geometry, over heads, resolutions and scenes, beside simpler filters.

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include <lcmslam/imaging/depth_filter.hpp>

namespace lcmslam {

/// Takes pixels out of a depth image (CV_16UC1 mm) in place; amplitude may be empty.
struct DepthFilterMethod {
  std::string name;
  std::function<std::function<void(cv::Mat& depth, const cv::Mat& amplitude)>(const RgbdCalibration&)> make;
};

/// Ours; a threshold on the gradient (OpenCV's dilation and erosion); a fixed angle between neighbours.
std::vector<DepthFilterMethod> depth_filter_methods(const DepthFilterSettings& settings = {});

struct DepthFilterStudySettings {
  std::vector<std::string> scenes;  ///< files
  std::vector<std::string> heads = {"tof", "rgbd"};
  std::vector<cv::Size> sizes = {{176, 144}, {320, 240}, {640, 480}};
  int images = 8;          ///< of each, spread over the scene's path
  std::uint64_t seed = 1;  ///< of the sensors' noise
  std::vector<double> curve = {0.8, 1.0, 1.2, 1.35, 1.5, 1.8, 2.2, 3.0};  ///< noise_sigmas tried besides

  void check() const;  ///< throws std::invalid_argument
};

/// One head, size and scene. See DepthClass for what is mixed and good.
struct DepthFilterScore {
  std::string scene, head, method;
  cv::Size size;
  std::int64_t mixed = 0, good = 0;  ///< pixels in all images
  std::int64_t mixed_removed = 0, good_removed = 0;
  double left_gap = 0;      ///< median distance of what mixed pixels are left from true surfaces, tolerances
  double milliseconds = 0;  ///< median processor time an image, one thread

  double removed_share() const;  ///< NaN where there are too few mixed pixels (fewer than 50) to tell
  double lost_share() const;
};

/// The worst over all cases with ours at another noise_sigmas.
struct DepthFilterPoint {
  double noise_sigmas = 0, removed_share = 1, lost_share = 0;
};

struct DepthFilterStudyResult {
  std::vector<DepthFilterScore> scores;
  std::vector<DepthFilterPoint> curve;
};

DepthFilterStudyResult study_depth_filter(const std::vector<DepthFilterMethod>& methods,
                                          const DepthFilterStudySettings& settings);

std::string depth_filter_table(const DepthFilterStudyResult& result);
nlohmann::json depth_filter_json(const DepthFilterStudyResult& result,
                                 const DepthFilterStudySettings& settings);

}  // namespace lcmslam

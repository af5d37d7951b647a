#pragma once
// Pictures of an experiment's maps: the same map from the front and from above, as JPEG.

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/features/landmark.hpp>
#include "tools/study/report/experiment.hpp"

namespace lcmslam {

struct MapPictures {
  /// Files go to `folder` and are called NAME_front.jpg and the like.
  MapPictures(std::filesystem::path folder, std::string name)
      : folder_(std::move(folder)), name_(std::move(name)) {}

  struct Path {
    std::string name;
    cv::Vec3b colour;  ///< BGR
    Trajectory path;
    Eigen::Isometry3d T_world_path;
  };
  const ColouredCloud* cloud = nullptr;
  const std::vector<Landmark>* landmarks = nullptr;
  Eigen::Isometry3d T_world_map = Eigen::Isometry3d::Identity();  ///< of cloud and landmarks
  std::vector<Path> paths;

  /// Front and top view.
  void add_views(ExperimentResult& result, const std::string& title) const;
  /// Writes any picture. Throws std::runtime_error naming the file.
  Picture add(const cv::Mat& picture, const std::string& ending, const std::string& title,
              const std::string& text) const;

 private:
  std::filesystem::path folder_;
  std::string name_;
};

}  // namespace lcmslam

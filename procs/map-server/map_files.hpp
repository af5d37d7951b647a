#pragma once
// The files of an export: PLY, PCD and pictures, of landmark maps and dense maps.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/map_store/landmark_map.hpp>

namespace lcmslam {

class MapFiles {
 public:
  /// `formats`: "ply", "pcd", "png", several separated by commas; empty: all. Throws std::runtime_error
  /// for others.
  MapFiles(std::filesystem::path folder, const std::string& formats);

  /// NAME_map.ply, NAME_map.pcd, NAME_front.png, NAME_top.png. `path`: the robot's, m.
  void save_landmarks(const std::string& name, const std::vector<Landmark>& landmarks,
                      const std::vector<Eigen::Vector3d>& path);
  void save_cloud(const std::string& name, const ColouredCloud& cloud, double resolution,
                  const std::vector<Eigen::Vector3d>& path);

  const std::vector<std::string>& written() const { return written_; }

 private:
  template <class Map>
  void save_points(const std::string& name, const Map& map);
  bool wants(const std::string& format) const { return formats_.count(format) > 0; }
  std::filesystem::path file(const std::string& name);

  std::filesystem::path folder_;
  std::set<std::string> formats_;
  std::vector<std::string> written_;
};

}  // namespace lcmslam

#pragma once
// Pictures of maps for reports and the command line, drawn without a graphics card.
//
// One looks into the room: surfaces that face away from the viewer (the ceiling from above, the near
// wall from behind) are left out. That needs normals; points without one are cut by height, and in the
// front view also those nearest to the viewer.

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/files/part_file.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/map_store/landmark_map.hpp>

namespace lcmslam {

enum class MapView {
  front,  ///< perspective, along the room's long side, from behind the start, raised
  top     ///< orthographic, x to the right, y up, with axes and scale bar
};

/// A trajectory, drawn as a line with a dot at its start, named in the legend.
struct PicturePath {
  std::string name;
  cv::Vec3b colour{0, 0, 200};          ///< BGR
  std::vector<Eigen::Vector3d> points;  ///< m, world; one that is not finite interrupts the line
};

/// World frame throughout: z up, m. Cloud and landmarks are not owned and may be absent.
struct PictureRequest {
  MapView view = MapView::top;
  int width = 1600, height = 1200;  ///< pixels, 64 to 8192
  std::string title;
  const ColouredCloud* cloud = nullptr;
  /// More points of the surfaces of `cloud`, sharper but rougher: where that is, they colour it.
  const ColouredCloud* paint = nullptr;
  const std::vector<Landmark>* landmarks = nullptr;  ///< dots, larger where more certain
  std::vector<PicturePath> paths;
  double resolution = 0.02;  ///< m, spacing of the cloud's points where they are densest
  bool dark = false;         ///< dark background instead of light
  /// Points above are left out; automatic when absent (only points without normal are cut then).
  std::optional<double> cut_height;
  /// Viewpoint of the front view (x right, y down, z forward); automatic when absent.
  std::optional<Eigen::Isometry3d> T_world_viewer;
  double field_of_view = 0.9;  ///< rad, horizontal, front view, 0.1 to 2.5
};

/// The picture, CV_8UC3. An empty map gives an empty frame that says so. Throws
/// std::invalid_argument for settings outside the ranges above.
cv::Mat draw_map(const PictureRequest& request);

/// Writes a PNG atomically; throws std::runtime_error naming file and reason.
void save_picture(const FilePlace& file, const cv::Mat& picture);

}  // namespace lcmslam

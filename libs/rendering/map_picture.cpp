#include <lcmslam/rendering/map_picture.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/rendering/front_heading.hpp>
#include <lcmslam/rendering/picture_annotations.hpp>
#include <lcmslam/rendering/picture_points.hpp>
#include <lcmslam/rendering/png.hpp>
#include <lcmslam/rendering/splat.hpp>
#include <lcmslam/rendering/view_camera.hpp>

namespace lcmslam {
namespace {

constexpr double pitch = 0.38;  // rad, the front view looks down by this much

void check(const PictureRequest& request) {
  const auto require = [](bool condition, const std::string& problem) {
    if (!condition) throw std::invalid_argument("map picture: " + problem);
  };
  const auto is_size = [](int pixels) { return pixels >= 64 && pixels <= 8192; };
  require(is_size(request.width) && is_size(request.height),
          "width and height must be from 64 to 8192 pixels");
  require(request.resolution > 0 && std::isfinite(request.resolution), "resolution must be positive");
  require(request.field_of_view >= 0.1 && request.field_of_view <= 2.5,
          "field_of_view must be from 0.1 to 2.5 rad");
  require(!request.cloud || request.cloud->colours.size() == request.cloud->size(),
          "every point of the cloud needs a colour");
}

ViewFrame frame_of(const PictureRequest& request, double unit) {
  const double side = request.view == MapView::top ? 95 * unit : 25 * unit;
  const double bottom = request.view == MapView::top ? 75 * unit : 25 * unit;
  const double top = 70 * unit;
  return {side, top, request.width - 2 * side, request.height - top - bottom};
}

ViewCamera place_camera(const PictureRequest& request, const ViewFrame& frame,
                        const std::vector<Eigen::Vector3d>& points) {
  if (request.view == MapView::top) return fit_top_view(points, frame);
  if (!request.T_world_viewer)
    return fit_perspective(points, frame, front_heading(request, points), pitch, request.field_of_view);
  ViewCamera camera;
  camera.T_camera_world = request.T_world_viewer->inverse();
  camera.scale = request.width / 2.0 / std::tan(request.field_of_view / 2);
  camera.cx = request.width / 2.0;
  camera.cy = request.height / 2.0;
  return camera;
}

}  // namespace

cv::Mat draw_map(const PictureRequest& request) {
  check(request);
  const PictureStyle style = picture_style(request);
  cv::Mat picture(request.height, request.width, CV_8UC3, style.background);
  const ViewFrame frame = frame_of(request, style.unit);

  // Twice: what faces away from a first camera must not push the final one back.
  const PicturePoints points(request);
  ViewCamera camera = place_camera(request, frame, points.extent(nullptr));
  camera = place_camera(request, frame, points.extent(&camera));

  if (points.empty()) {
    draw_text(picture, "empty map", {request.width / 2.0, request.height / 2.0}, 1.2, style);
    draw_title_and_legend(picture, request, style);
    return picture;
  }
  if (request.view == MapView::top) draw_top_grid(picture, camera, frame, style);
  const std::vector<SplatPoint> splats = points.visible(camera);
  if (request.view == MapView::front && splats.empty())
    draw_ground(picture, camera, points.extent(nullptr), style);
  draw_splats(picture, camera, splats);
  if (request.landmarks) draw_landmarks(picture, camera, *request.landmarks, style);
  for (const PicturePath& path : request.paths) draw_path(picture, camera, path, style);
  if (request.view == MapView::top) draw_top_axes(picture, camera, frame, style);
  draw_title_and_legend(picture, request, style);
  return picture;
}

void save_picture(const FilePlace& file, const cv::Mat& picture) {
  if (picture.empty()) throw std::runtime_error("cannot save " + file.path().string() + ": not a picture");
  write_atomically(file, encode_png(picture));
}

}  // namespace lcmslam

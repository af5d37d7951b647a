#include "tools/study/report/map_pictures.hpp"

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include <lcmslam/rendering/map_picture.hpp>

namespace lcmslam {

Picture MapPictures::add(const cv::Mat& picture, const std::string& ending, const std::string& title,
                         const std::string& text) const {
  std::filesystem::create_directories(folder_);
  const std::filesystem::path file = folder_ / (name_ + "_" + ending + ".jpg");
  if (!cv::imwrite(file.string(), picture, {cv::IMWRITE_JPEG_QUALITY, 80}))
    throw std::runtime_error(file.string() + ": cannot be written");
  return {title, text, file};
}

void MapPictures::add_views(ExperimentResult& result, const std::string& title) const {
  PictureRequest request;
  request.width = 900;
  request.height = 675;
  ColouredCloud world;
  if (cloud != nullptr) {
    const Eigen::Isometry3f T = T_world_map.cast<float>();
    world = *cloud;
    for (Eigen::Vector3f& point : world.points) point = T * point;
    for (Eigen::Vector3f& normal : world.normals) normal = T.linear() * normal;
    request.cloud = &world;
  }
  std::vector<Landmark> placed;
  if (landmarks != nullptr) {
    placed = *landmarks;
    for (Landmark& landmark : placed) {
      landmark.mean = T_world_map * landmark.mean;
      landmark.covariance = T_world_map.linear() * landmark.covariance * T_world_map.linear().transpose();
    }
    request.landmarks = &placed;
  }
  for (const Path& path : paths) {
    PicturePath drawn{path.name, path.colour, {}};
    for (const StampedPose& pose : path.path)
      drawn.points.emplace_back((path.T_world_path * pose.T_world_body).translation());
    request.paths.push_back(std::move(drawn));
  }
  for (const MapView view : {MapView::front, MapView::top}) {
    const bool top = view == MapView::top;
    request.view = view;
    result.pictures.push_back(add(draw_map(request), top ? "top" : "front",
                                  title + (top ? ", from above" : ", from the front"),
                                  (cloud != nullptr ? "The cloud of the map" : "The landmarks of the map") +
                                      std::string(top ? " from above, with the paths driven in it."
                                                      : " from behind the start, with the paths driven.")));
  }
}

}  // namespace lcmslam

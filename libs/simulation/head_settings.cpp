#include <lcmslam/simulation/head_settings.hpp>

#include <lcmslam/configuration/read_settings.hpp>

namespace lcmslam {

CameraModel LensSettings::camera() const {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = cx > 0 ? cx : (width - 1) / 2.0;
  camera.cy = cy > 0 ? cy : (height - 1) / 2.0;
  camera.distortion = distortion;
  return camera;
}

HeadSettings load_head(const std::filesystem::path& file) {
  const ConfigNode config = ConfigNode::load(file);
  auto settings = read_settings<HeadSettings>(config);
  settings.name = file.stem().string();
  config.finish();
  return settings;
}

}  // namespace lcmslam

#include "procs/camera/drivers/video_shot.hpp"

#include <limits>
#include <opencv2/imgproc.hpp>

#include <lcmslam/cameras/camera_device.hpp>

namespace lcmslam {
namespace {

/// Raw values of 16 bits, steps of `unit` metres, in millimetres. The largest value stands for no distance,
/// but for one beyond or for none, whatever the unit.
cv::Mat depth_in_millimetres(const cv::Mat& image, double unit, const std::string& name) {
  if (image.type() != CV_16UC1)
    throw CameraError(name + ": is not depth: images must have one channel of 16 bits");
  cv::Mat depth;
  image.convertTo(depth, CV_16UC1, unit * 1000);
  depth.setTo(0, image == std::numeric_limits<std::uint16_t>::max());
  return depth;
}

cv::Mat colour_in_bgr(const cv::Mat& image, const std::string& name) {
  cv::Mat bgr;
  if (image.type() == CV_8UC3)
    bgr = image.clone();
  else if (image.type() == CV_8UC1)
    cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  else if (image.type() == CV_8UC4)
    cv::cvtColor(image, bgr, cv::COLOR_BGRA2BGR);
  else
    throw CameraError(name + ": images must have 8 bits in 1, 3 or 4 channels; depth: `images: depth`");
  return bgr;
}

}  // namespace

CameraShot video_shot(const cv::Mat& image, Utime utime, const VideoSettings& settings,
                      const std::string& name) {
  CameraShot shot;
  shot.utime = shot.depth_utime = utime;
  if (settings.images == "depth")
    shot.depth = depth_in_millimetres(image, settings.depth_unit, name);
  else
    shot.colour = colour_in_bgr(image, name);
  return shot;
}

}  // namespace lcmslam

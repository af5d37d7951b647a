#pragma once
#include <opencv2/core.hpp>

#include <lcmslam/cameras/camera_shot.hpp>
#include "procs/camera/drivers/driver_settings.hpp"

namespace lcmslam {

/// An image as OpenCV decodes it, as colour or depth, as the settings say. Throws CameraError, which begins
/// with `name`, when it is none.
CameraShot video_shot(const cv::Mat& image, Utime utime, const VideoSettings& settings,
                      const std::string& name);

}  // namespace lcmslam

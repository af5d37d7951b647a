#include "procs/camera/encode_shot.hpp"

#include <lcmslam/imaging/io/codec.hpp>

namespace lcmslam {

EncodedFrame encode_shot(CameraShot frame, const RgbdCalibration& calibration, int jpeg_quality) {
  if (frame.colour.empty() && frame.jpeg.empty())
    frame.colour = cv::Mat::zeros(calibration.colour.height, calibration.colour.width, CV_8UC3);
  if (frame.depth.empty())
    frame.depth = cv::Mat::zeros(calibration.depth.height, calibration.depth.width, CV_16UC1);
  EncodedFrame encoded = encode(frame, jpeg_quality);
  encoded.sensor = calibration.sensor;
  if (!frame.jpeg.empty())
    encoded.colour = {frame.utime, frame.jpeg_size.width, frame.jpeg_size.height, ImageCoding::jpeg,
                      std::move(frame.jpeg)};
  return encoded;
}

}  // namespace lcmslam

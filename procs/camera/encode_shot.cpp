#include "procs/camera/encode_shot.hpp"

#include <lcmslam/imaging/io/codec.hpp>

namespace lcmslam {

EncodedFrame encode_shot(RgbdFrame frame, const RgbdCalibration& calibration, int jpeg_quality) {
  if (frame.colour.empty())
    frame.colour = cv::Mat::zeros(calibration.colour.height, calibration.colour.width, CV_8UC3);
  if (frame.depth.empty())
    frame.depth = cv::Mat::zeros(calibration.depth.height, calibration.depth.width, CV_16UC1);
  EncodedFrame encoded = encode(frame, jpeg_quality);
  encoded.sensor = calibration.sensor;
  return encoded;
}

}  // namespace lcmslam

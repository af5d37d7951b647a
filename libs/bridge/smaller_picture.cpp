#include <lcmslam/bridge/smaller_picture.hpp>

#include <opencv2/imgproc.hpp>

#include <lcmslam/imaging/io/codec.hpp>

namespace lcmslam::bridge {

EncodedFrame smaller_picture(const EncodedFrame& frame, int width, int quality) {
  EncodedFrame smaller;
  smaller.utime = frame.utime;
  smaller.seq = frame.seq;
  smaller.sensor = frame.sensor;
  if (frame.colour.coding == ImageCoding::none) return smaller;
  cv::Mat image = decode_colour(frame.colour);
  if (image.cols > width) {
    const int height = std::max(1, image.rows * width / image.cols);
    cv::Mat small;
    cv::resize(image, small, cv::Size(width, height), 0, 0, cv::INTER_AREA);
    image = small;
  }
  smaller.colour = encode_colour(image, frame.colour.utime, quality);
  return smaller;
}

}  // namespace lcmslam::bridge

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/ros/definitions.hpp>
#include <lcmslam/ros/images.hpp>
#include <lcmslam/ros/message_writers.hpp>

namespace lcmslam::ros {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

/// As ROS 1 lays fields out: one after another.
class PackedImage {
 public:
  PackedImage(std::uint32_t width, std::uint32_t height, const std::string& encoding, std::uint32_t step,
              ByteView pixels, bool big_endian = false) {
    writer_.number(std::uint32_t{7});  // seq
    writer_.number(std::uint32_t{12});
    writer_.number(std::uint32_t{345'678'000});
    writer_.text("/camera");
    writer_.number(height);
    writer_.number(width);
    writer_.text(encoding);
    writer_.number(big_endian);
    writer_.number(step);
    writer_.text(pixels.text());
  }
  Image read() const { return read_image(writer_.view(), "sensor_msgs/Image", "ros1"); }
  ByteView view() const { return writer_.view(); }

 private:
  ByteWriter writer_;
};

ByteView view(const Bytes& bytes) {
  return {bytes.data(), bytes.size()};
}

TEST(RosMessages, OfRos1AndOfRos2SayTheSame) {
  const Bytes pixels = {1, 2, 3, 4, 5, 6, 7, 8};
  const PackedImage of_ros1(2, 2, "16UC1", 4, view(pixels));
  const Image packed = of_ros1.read();
  const CdrWriter written =
      write_image({12'345'678, "camera"}, cv::Mat(2, 2, CV_16UC1, const_cast<std::uint8_t*>(pixels.data())));
  const Image aligned = read_image(written.view(), "sensor_msgs/Image", "cdr");
  for (const Image& image : {packed, aligned}) {
    EXPECT_EQ(image.header.utime, 12'345'678);
    EXPECT_EQ(image.header.frame, "camera");
    EXPECT_EQ(image.width, 2U);
    EXPECT_EQ(image.encoding, "16UC1");
    EXPECT_EQ(image.step, 4U);
    EXPECT_EQ(image.data.text(), view(pixels).text());
  }
}

TEST(RosMessages, OfBothByteOrdersSayTheSame) {
  // {uint8 1, uint32 0x01020304, float64 1.0}
  const Bytes little = {0, 1, 0, 0, 1, 0, 0, 0, 4, 3, 2, 1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f};
  const Bytes big = {0, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3, 4, 0x3f, 0xf0, 0, 0, 0, 0, 0, 0};
  for (const Bytes& bytes : {little, big}) {
    RosReader reader(view(bytes), "cdr");
    EXPECT_EQ(reader.number<std::uint8_t>(), 1);
    EXPECT_EQ(reader.number<std::uint32_t>(), 0x01020304U);
    EXPECT_EQ(reader.number<double>(), 1.0);
    reader.finish();
  }
}

TEST(RosMessages, DoublesOfCdrVersion2AreAlignedToFour) {
  // {uint32 1, float64 1.0}: version 1 puts four bytes between them
  const Bytes bytes = {0, 7, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f};
  RosReader reader(view(bytes), "cdr");
  reader.number<std::uint32_t>();
  EXPECT_EQ(reader.number<double>(), 1.0);
}

TEST(RosMessages, CutAnywhereAreRefused) {
  const CameraModel camera{640, 480, 500, 501, 320, 240, {0.1, 0.2, 0.3, 0.4, 0.5}};
  const CdrWriter whole = write_camera_info({1, "camera"}, camera);
  EXPECT_EQ(read_camera_info(whole.view(), "cdr").K[4], 501);
  EXPECT_EQ(read_camera_info(whole.view(), "cdr").D[4], 0.5);
  for (std::size_t size = 0; size + 1 < whole.view().size; ++size)
    EXPECT_THROW(read_camera_info({whole.view().data, size}, "cdr"), RecordingError) << size;
  Bytes longer(whole.view().data, whole.view().data + whole.view().size);
  longer.resize(longer.size() + 8);
  EXPECT_THROW(read_camera_info(view(longer), "cdr"), RecordingError);
}

TEST(RosMessages, PosesAndTransformsComeBack) {
  Eigen::Isometry3d T = planar_pose(1, 2, 0.3);
  const CdrWriter odometry = write_odometry({5, "odom"}, "base_link", T, Matrix6d::Identity(), {1, 0, 0},
                                            {0, 0, 2}, Matrix6d::Identity());
  const Pose pose = read_pose(odometry.view(), "nav_msgs/Odometry", "cdr");
  EXPECT_TRUE(pose.pose.isApprox(T, 1e-12));
  EXPECT_EQ(pose.child_frame, "base_link");
  EXPECT_EQ(pose.angular.z(), 2);
  const auto transforms =
      read_transforms(write_transforms({{{5, "a"}, "b", T}, {{5, "b"}, "c", T}}).view(), "cdr").usable;
  ASSERT_EQ(transforms.size(), 2U);
  EXPECT_EQ(transforms[1].child_frame, "c");
  EXPECT_TRUE(transforms[1].T_parent_child.isApprox(T, 1e-12));
}

TEST(RosMessages, CovariancesTurnIntoTheParentsAxes) {
  Matrix6d covariance = Matrix6d::Identity();
  covariance(0, 0) = 4;  // along the robot's x, which lies between the parent's x and y
  const Matrix6d turned = covariance_in_parent(planar_pose(3, 4, M_PI / 4), covariance);
  EXPECT_NEAR(turned(0, 0), 2.5, 1e-12);
  EXPECT_NEAR(turned(0, 1), 1.5, 1e-12);
}

TEST(RosImages, ColoursOfEachEncodingAreTheSame) {
  const Bytes bgr = {10, 120, 230}, rgb = {230, 120, 10}, bgra = {10, 120, 230, 9}, rgba = {230, 120, 10, 9};
  const auto mean = [](const std::string& encoding, const Bytes& pixel) {
    Bytes pixels;  // 16x16, rows longer than they must be
    const std::size_t padding = 5;
    for (int v = 0; v < 16; ++v) {
      for (int u = 0; u < 16; ++u) pixels.insert(pixels.end(), pixel.begin(), pixel.end());
      pixels.resize(pixels.size() + padding, 77);
    }
    const PackedImage packed(16, 16, encoding, static_cast<std::uint32_t>(16 * pixel.size() + padding),
                             view(pixels));
    const std::string before(packed.view().text());
    const cv::Scalar colour = cv::mean(decode_colour(to_colour(packed.read(), 1, 95)));
    EXPECT_TRUE(packed.view().text() == before) << encoding << " is changed in the recording";
    return colour;
  };
  for (const auto& colour : {mean("bgr8", bgr), mean("rgb8", rgb), mean("bgra8", bgra), mean("rgba8", rgba)})
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(colour[i], bgr[static_cast<std::size_t>(i)], 4);
  EXPECT_NEAR(mean("mono8", {90})[2], 90, 2);
}

TEST(RosImages, DepthOfEachEncodingIsInMillimetres) {
  const auto pixel = [](const EncodedImage& image) { return decode_depth(image).at<std::uint16_t>(1, 1); };
  const std::uint16_t mm[4] = {1, 65535, 3, 1234}, swapped[4] = {0, 0, 0, 0xd204};
  const auto bytes = [](const auto& values) {
    return ByteView{reinterpret_cast<const std::uint8_t*>(values), sizeof values};
  };
  EXPECT_EQ(pixel(to_depth(PackedImage(2, 2, "16UC1", 4, bytes(mm)).read(), 1)), 1234);
  EXPECT_EQ(pixel(to_depth(PackedImage(2, 2, "16UC1", 4, bytes(swapped), true).read(), 1)), 1234);
  EXPECT_EQ(
      decode_depth(to_depth(PackedImage(2, 2, "16UC1", 4, bytes(mm)).read(), 1)).at<std::uint16_t>(0, 1), 0);
  const float metres[4] = {std::nanf(""), 1e9F, -1, 1.2344F};
  const cv::Mat depth = decode_depth(to_depth(PackedImage(2, 2, "32FC1", 8, bytes(metres)).read(), 1));
  EXPECT_EQ(cv::countNonZero(depth), 1);
  EXPECT_EQ(depth.at<std::uint16_t>(1, 1), 1234);
}

TEST(RosImages, CompressedDepthIsRead) {
  cv::Mat png_pixels(2, 2, CV_16UC1, cv::Scalar(1500));
  png_pixels.at<std::uint16_t>(0, 0) = 0;
  Bytes png;
  cv::imencode(".png", png_pixels, png);
  const auto image = [&](const std::string& format, float a, float b) {
    Bytes data(12);
    std::memcpy(data.data() + 4, &a, 4);
    std::memcpy(data.data() + 8, &b, 4);
    data.insert(data.end(), png.begin(), png.end());
    const CdrWriter message = write_compressed_image({1, "camera"}, format, view(data));
    const Image read = read_image(message.view(), "sensor_msgs/CompressedImage", "cdr");
    EXPECT_EQ(kind_of(read), ImageKind::depth);
    EXPECT_EQ(size_of(read).width, 2);
    return decode_depth(to_depth(read, 1));
  };
  EXPECT_EQ(image("16UC1; compressedDepth png", 0, 0).at<std::uint16_t>(1, 1), 1500);
  // 1 / depth is kept: depth = a / (value - b)
  const cv::Mat inverse = image("32FC1; compressedDepth png", 2800, 100);
  EXPECT_EQ(inverse.at<std::uint16_t>(1, 1), 2000);
  EXPECT_EQ(inverse.at<std::uint16_t>(0, 0), 0);
}

TEST(RosImages, WhatDoesNotFitIsRefused) {
  const Bytes pixels(12);
  const auto refusal = [&](const PackedImage& packed) -> std::string {
    try {
      to_colour(packed.read(), 1, 90);
    } catch (const CodecError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal(PackedImage(2, 2, "rgb8", 5, view(pixels))), HasSubstr("rows of 5 bytes"));
  EXPECT_THAT(refusal(PackedImage(2, 3, "rgb8", 6, view(pixels))), HasSubstr("has 12 bytes"));
  EXPECT_THAT(refusal(PackedImage(0x80000000, 1, "rgb8", 6, view(pixels))), HasSubstr("at most 32 Mpixel"));
  EXPECT_THAT(refusal(PackedImage(2, 2, "bayer_rggb8", 6, view(pixels))),
              HasSubstr("'bayer_rggb8' is no colour"));
  const CdrWriter no_image = write_compressed_image({1, "c"}, "jpeg", view(pixels));
  EXPECT_THROW(to_colour(read_image(no_image.view(), "sensor_msgs/CompressedImage", "cdr"), 1, 90),
               CodecError);
}

TEST(RosDefinitions, AreWholeAndEachTypeStandsOnce) {
  const std::string text = message_definition("nav_msgs/msg/Odometry");
  for (const char* member :
       {"MSG: std_msgs/Header", "MSG: geometry_msgs/Quaternion", "MSG: geometry_msgs/Vector3"}) {
    const std::size_t first = text.find(member);
    EXPECT_NE(first, std::string::npos) << member;
    EXPECT_EQ(text.find(member, first + 1), std::string::npos) << member;
  }
  EXPECT_THROW(message_definition("std_msgs/msg/Nothing"), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam::ros

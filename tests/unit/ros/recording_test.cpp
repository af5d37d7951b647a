#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/recordings/mcap_format.hpp>
#include <lcmslam/recordings/mcap_writer.hpp>
#include <lcmslam/ros/definitions.hpp>
#include <lcmslam/ros/head_calibration.hpp>
#include <lcmslam/ros/message_writers.hpp>
#include <lcmslam/ros/ros_recording.hpp>

namespace lcmslam::ros {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const CameraModel camera{32, 24, 30, 31, 15.5, 11.5, {0.1, 0, 0, 0, 0}};

/// A drive of a robot that a test writes: colour at 0, 100, 200 ms ..., depth 5 ms later.
class RosDrive : public ::testing::Test {
 protected:
  void begin(const McapWriter::Options& options = {}) {
    writer_ = std::make_unique<McapWriter>(file(), options);
  }
  void close() {
    channels_.clear();
    if (writer_) writer_->close();
    writer_.reset();
  }
  std::string file() const {
    return ::testing::TempDir() + "ros_drive_" + std::to_string(getpid()) + ".mcap";
  }
  ~RosDrive() override { std::filesystem::remove(file()); }

  void write(const std::string& topic, const std::string& type, Utime utime, const CdrWriter& message) {
    auto known = channels_.find(topic);
    if (known == channels_.end())
      known = channels_.emplace(topic, writer_->add_channel(topic, type, message_definition(type))).first;
    writer_->write(known->second, utime * 1000, utime * 1000, message.view());
  }
  void write_colour(Utime utime, const std::string& frame = "colour") {
    write("/cam/color/image_raw", "sensor_msgs/msg/Image", utime,
          write_image({utime, frame}, cv::Mat(24, 32, CV_8UC3, cv::Scalar(1, 2, 3))));
  }
  void write_depth(Utime utime, const std::string& frame = "depth", cv::Size size = {32, 24},
                   const std::string& topic = "/cam/depth/image") {
    write(topic, "sensor_msgs/msg/Image", utime,
          write_image({utime, frame}, cv::Mat(size, CV_16UC1, cv::Scalar(1000))));
  }
  void write_info(const std::string& topic, const std::string& frame) {
    write(topic, "sensor_msgs/msg/CameraInfo", 1000, write_camera_info({1000, frame}, camera));
  }
  void write_infos() {
    write_info("/cam/color/camera_info", "colour");
    write_info("/cam/depth/camera_info", "depth");
  }
  void write_tf(const std::vector<Transform>& transforms) {
    write("/tf_static", "tf2_msgs/msg/TFMessage", 1000, write_transforms(transforms));
  }
  void write_tf(const std::string& parent, const std::string& child, const Eigen::Isometry3d& T) {
    write_tf({{{1000, parent}, child, T}});
  }
  void write_odometry_at(Utime utime, double x, const std::string& robot = "base_link") {
    write("/odom", "nav_msgs/msg/Odometry", utime,
          write_odometry({utime, "odom"}, robot, planar_pose(x, 0, 0), Matrix6d::Zero(), {0.5, 0, 0},
                         {0, 0, 0}, Matrix6d::Zero()));
  }
  RosRecording open(const RosOptions& options = {}) {
    close();
    return RosRecording({file()}, options);
  }
  std::string refusal(const RosOptions& options = {}) {
    try {
      open(options);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

 private:
  std::unique_ptr<McapWriter> writer_;
  std::map<std::string, std::uint16_t> channels_;
};

Eigen::Isometry3d moved(double x, double y, double z) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x, y, z;
  return T;
}

TEST_F(RosDrive, BecomesFramesAndOdometryInOrderOfTime) {
  begin();
  for (int i = 0; i < 4; ++i) write_depth(100'000 + 100'000 * i + 5000);  // written before all colour
  for (int i = 0; i < 5; ++i) write_colour(100'000 + 100'000 * i);        // the last one has no depth
  for (int i = 0; i < 3; ++i) write_odometry_at(50'000 + 100'000 * i, i);
  write_infos();
  write_tf("base_link", "head", moved(0, 0, 1));
  write_tf("head", "colour", moved(0.1, 0, 0));
  write_tf("head", "depth", moved(0.1, 0.05, 0));
  RosRecording recording = open();
  EXPECT_EQ(recording.frames(), 4U);
  EXPECT_THAT(recording.notes(),
              Contains(HasSubstr("1 of 5 images of /cam/color/image_raw have no depth image")));
  const RgbdCalibration& calibration = recording.calibration();
  EXPECT_TRUE(calibration.has_mount);
  EXPECT_TRUE(calibration.T_robot_camera.isApprox(moved(0.1, 0, 1)));
  EXPECT_TRUE(calibration.T_colour_depth.isApprox(moved(0, 0.05, 0)));
  EXPECT_FALSE(calibration.depth_registered);
  EXPECT_EQ(calibration.colour.distortion.front(), 0.1);
  std::string order;
  Utime last = 0;
  while (const auto event = recording.next()) {
    if (const auto* frame = std::get_if<EncodedFrame>(&*event)) {
      order += 'f';
      EXPECT_GE(frame->utime, last);
      last = frame->utime;
      EXPECT_EQ(frame->depth.utime, frame->utime + 5000);
      EXPECT_EQ(decode_depth(frame->depth).at<std::uint16_t>(5, 5), 1000);
    } else if (const auto* odometry = std::get_if<OdometryEvent>(&*event)) {
      order += 'o';
      EXPECT_GE(odometry->utime, last);
      last = odometry->utime;
      EXPECT_EQ(odometry->twist.linear.x(), 0.5);
      EXPECT_NEAR(odometry->T_odom_robot.translation().x(), static_cast<double>(last - 50'000) / 1e5, 1e-9);
    }
  }
  EXPECT_EQ(order, "ofofoff");
  EXPECT_THAT(recording.problems(), IsEmpty());
}

/// The records, those of chunks (which must not be packed) by themselves.
void add_unchunked(ByteReader records, ByteWriter& to) {
  while (!records.done()) {
    const auto kind = records.number<mcap::Record>();
    const ByteView content = records.sized<std::uint64_t>();
    if (kind == mcap::Record::data_end) return;
    if (kind == mcap::Record::chunk) {
      ByteReader chunk(content);
      chunk.take(8 + 8 + 8 + 4);  // times, size, CRC
      chunk.text();               // compression
      add_unchunked(ByteReader(chunk.sized<std::uint64_t>()), to);
    } else if (kind != mcap::Record::message_index) {
      to.number(kind);
      to.number(static_cast<std::uint64_t>(content.size));
      to.raw(content);
    }
  }
}

/// The MCAP file as recorders write it that use no chunks: what is read then are the file's own bytes.
std::string unchunked(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
  ByteReader records({bytes.data(), bytes.size()});
  ByteWriter made;
  made.raw(records.take(mcap::magic.size()));
  add_unchunked(records, made);
  made.number(mcap::Record::footer);
  made.number(static_cast<std::uint64_t>(mcap::footer_size));
  made.raw(std::string(mcap::footer_size, '\0'));
  made.raw(mcap::magic);
  return std::string(made.view().text());
}

TEST_F(RosDrive, ColoursOfAFileWithoutChunksAreReadWhereTheyLie) {
  McapWriter::Options options;
  options.compression = "";
  begin(options);
  write("/cam/color/image_raw", "sensor_msgs/msg/Image", 100'000,
        write_image({100'000, "colour"}, cv::Mat(24, 32, CV_8UC3, cv::Scalar(230, 120, 10))));
  write_depth(100'000, "colour");
  write_infos();
  close();
  std::string text = unchunked(file());
  text.replace(text.find("bgr8"), 4, "rgb8");
  std::ofstream(file(), std::ios::binary) << text;
  RosRecording recording = open();
  EXPECT_THAT(recording.problems(), IsEmpty());
  const auto frame = std::get<EncodedFrame>(*recording.next());
  EXPECT_NEAR(cv::mean(decode_colour(frame.colour))[0], 10, 4);
}

/// As a calibration file says it.
std::filesystem::path head_whose_depth_clock_is_off(const std::string& file, double seconds) {
  const std::string model = "{width: 32, height: 24, fx: 30, fy: 31, cx: 15.5, cy: 11.5}\n";
  std::ofstream(file) << "colour: " << model << "depth: " << model
                      << "colour_depth: {translation: [0, 0, 0], quaternion: [1, 0, 0, 0]}\n"
                      << "depth_clock_offset: " << seconds << "\n";
  return file;
}

TEST_F(RosDrive, PairsByTheDepthClockOfItsCalibration) {
  RosOptions options;
  options.calibration = head_whose_depth_clock_is_off(file() + ".yaml", 1.5);
  begin();
  for (int i = 0; i < 6; ++i) {
    write_colour(2'000'000 + 100'000 * i);
    write_depth(2'005'000 - 1'500'000 + 100'000 * i);
  }
  RosRecording recording = open(options);
  std::filesystem::remove(options.calibration);
  EXPECT_EQ(recording.frames(), 6U);
  while (const auto event = recording.next()) {
    const auto& frame = std::get<EncodedFrame>(*event);
    EXPECT_EQ(frame.depth.utime, frame.utime + 5'000 - 1'500'000) << "as the camera stamped it";
  }
}

TEST_F(RosDrive, AnOffsetThatIsNoneIsLeftOut) {
  begin();
  write("/cam/depth/clock_offset", "std_msgs/msg/Float64", 1000, write_number(std::nan("")));
  write("/cam/depth/clock_offset", "std_msgs/msg/Float64", 1000, write_number(11));
  write("/elsewhere/clock_offset", "std_msgs/msg/Float64", 1000, write_number(1));
  write_colour(100'000);
  write_depth(100'000, "colour");
  write_infos();
  const RosRecording recording = open();
  EXPECT_EQ(recording.frames(), 1U);
  EXPECT_EQ(recording.calibration().depth_clock_offset, 0);
  EXPECT_THAT(recording.problems(), ElementsAre(HasSubstr("/cam/depth/clock_offset"), HasSubstr("10 s")));
}

TEST_F(RosDrive, DepthOfColoursFrameIsRegistered) {
  begin();
  write_colour(100'000);
  write_depth(100'000, "colour");
  write_infos();
  const RosRecording recording = open();
  EXPECT_TRUE(recording.calibration().depth_registered);
  EXPECT_FALSE(recording.calibration().has_mount);
  EXPECT_THAT(recording.notes(), Contains(HasSubstr("no mount")));
}

TEST_F(RosDrive, WithoutAWayBetweenTheCamerasItSaysWhatHelps) {
  begin();
  write_colour(100'000);
  write_depth(100'000);
  write_infos();
  EXPECT_THAT(refusal(), ::testing::AllOf(HasSubstr("from colour to depth"), HasSubstr("--calibration")));
}

TEST_F(RosDrive, WithoutIntrinsicsItSaysWhatHelps) {
  begin();
  write_colour(100'000);
  write_depth(100'000);
  EXPECT_THAT(refusal(),
              ::testing::AllOf(HasSubstr("/cam/color/camera_info is not there"), HasSubstr("--calibration")));
}

TEST_F(RosDrive, WithoutDepthItListsTheTopics) {
  begin();
  write_colour(100'000);
  EXPECT_THAT(refusal(),
              ::testing::AllOf(HasSubstr("no topic of depth images"), HasSubstr("/cam/color/image_raw")));
}

TEST_F(RosDrive, OdometryOfAFrameThatNobodyPlacesIsLeftOut) {
  begin();
  write_colour(100'000);
  write_depth(100'000, "colour");
  write_infos();
  write_odometry_at(100'000, 1);
  RosRecording recording = open();
  EXPECT_THAT(recording.notes(), Contains(HasSubstr("odometry is left out")));
  while (const auto event = recording.next()) EXPECT_TRUE(std::holds_alternative<EncodedFrame>(*event));
}

TEST_F(RosDrive, TruthIsOfTheBodyThatItNames) {
  begin();
  write_colour(100'000);
  write_depth(100'000, "colour");
  write_infos();
  write_tf("colour", "prism", moved(0, 0, 0.2));
  write("/ground_truth", "nav_msgs/msg/Odometry", 100'000,
        write_odometry({100'000, "world"}, "prism", moved(1, 2, 3), Matrix6d::Zero(), {0, 0, 0}, {0, 0, 0},
                       Matrix6d::Zero()));
  RosRecording recording = open();
  EXPECT_THAT(recording.notes(), Contains(HasSubstr("/ground_truth: true poses are of prism")));
  const auto truth = std::get<TruthEvent>(*recording.next());
  EXPECT_EQ(truth.body, "camera");
  EXPECT_TRUE(truth.T_world_body.isApprox(moved(1, 2, 2.8)));
}

TEST_F(RosDrive, OdometryOfNoFrameIsLeftOut) {
  begin();
  write_colour(100'000);
  write_depth(100'000, "colour");
  write_infos();
  write_odometry_at(100'000, 1, "");
  RosRecording recording = open();
  EXPECT_THAT(recording.notes(), Contains(HasSubstr("odometry is left out: it is of no frame")));
  while (const auto event = recording.next()) EXPECT_TRUE(std::holds_alternative<EncodedFrame>(*event));
}

TEST_F(RosDrive, ImagesOfNoFrameAreNotOfOneFrame) {
  begin();
  write_colour(100'000, "");
  write_depth(100'000, "");
  write_info("/cam/color/camera_info", "");
  write_info("/cam/depth/camera_info", "");
  EXPECT_THAT(refusal(), ::testing::AllOf(HasSubstr("/cam/depth/image"), HasSubstr("no frame"),
                                          HasSubstr("--calibration")));
}

TEST_F(RosDrive, WithoutCameraInfoDepthOfNoFrameDoesNotShareColours) {
  begin();
  write_colour(100'000, "");
  write_depth(100'000, "");
  write_info("/cam/color/camera_info", "");
  EXPECT_THAT(refusal(),
              ::testing::AllOf(HasSubstr("/cam/depth/camera_info is not there"), HasSubstr("--calibration")));
}

TEST_F(RosDrive, CameraInfoOfNoFrameBelongsToNoOtherTopic) {
  begin();
  write_colour(100'000, "");
  write_depth(100'000, "");
  write_info("/elsewhere/camera_info", "");
  EXPECT_THAT(refusal(), ::testing::AllOf(::testing::StartsWith(file() + ": "),
                                          HasSubstr("/cam/color/camera_info is not there")));
}

TEST_F(RosDrive, DepthWhoseTopicSaysSoIsRegisteredWithoutFrames) {
  begin();
  write_colour(100'000, "");
  write_depth(100'000, "", {32, 24}, "/cam/aligned_depth/image");
  write_info("/cam/color/camera_info", "");
  const RosRecording recording = open();
  EXPECT_TRUE(recording.calibration().depth_registered);
  EXPECT_THAT(recording.notes(), Contains(HasSubstr("/cam/aligned_depth/image says so")));
}

TEST_F(RosDrive, DepthThatIsAlignedToAnotherCameraStandsWhereTfSaysSo) {
  begin();
  write_colour(100'000);
  write_depth(100'000, "infra", {32, 24}, "/cam/aligned_depth_to_infra/image");
  write_info("/cam/color/camera_info", "colour");
  write_info("/cam/aligned_depth_to_infra/camera_info", "infra");
  write_tf("colour", "infra", moved(0.059, 0, 0));
  const RosRecording recording = open();
  EXPECT_FALSE(recording.calibration().depth_registered);
  EXPECT_TRUE(recording.calibration().T_colour_depth.isApprox(moved(0.059, 0, 0)));
  EXPECT_THAT(recording.notes(),
              Contains(AllOf(HasSubstr("by tf: 0.059, 0.000, 0.000 m"),
                             HasSubstr("/cam/aligned_depth_to_infra/image is not taken as registered"))));
}

TEST_F(RosDrive, DepthThatIsAlignedToAnotherCameraDoesNotShareColoursCameraInfo) {
  begin();
  write_colour(100'000);
  write_depth(100'000, "infra", {32, 24}, "/cam/aligned_depth_to_infra/image");
  write_info("/cam/color/camera_info", "colour");
  write_tf("colour", "infra", moved(0.059, 0, 0));
  EXPECT_THAT(refusal(), HasSubstr("no CameraInfo belongs to /cam/aligned_depth_to_infra/image"));
}

TEST_F(RosDrive, DepthWhoseTopicSaysSoIsRegisteredWhereTfDoesNotSayOtherwise) {
  for (const bool has_tf : {false, true}) {
    begin();
    write_colour(100'000);
    write_depth(100'000, "aligned", {32, 24}, "/cam/aligned_depth/image");
    write_info("/cam/color/camera_info", "colour");
    if (has_tf) write_tf("colour", "aligned", moved(0, 0, 0));
    EXPECT_TRUE(open().calibration().depth_registered) << "tf: " << has_tf;
  }
}

/// As a driver's bug writes it: the quaternion is no unit one.
Eigen::Isometry3d no_pose() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() *= 1.2;
  return T;
}

TEST_F(RosDrive, ATransformThatIsNoneIsLeftOutAlone) {
  begin();
  write_colour(100'000);
  write_depth(100'000);
  write_infos();
  for (int i = 0; i < 2; ++i)
    write_tf({{{1000, "head"}, "colour", moved(0.1, 0, 0)},
              {{1000, "base"}, "gripper", no_pose()},
              {{1000, "head"}, "depth", moved(0.1, 0.05, 0)}});
  const RosRecording recording = open();
  EXPECT_TRUE(recording.calibration().T_colour_depth.isApprox(moved(0, 0.05, 0)));
  EXPECT_THAT(recording.problems(),
              ElementsAre(::testing::AllOf(HasSubstr("/tf_static"), HasSubstr("from base to gripper"),
                                           HasSubstr("2 times"), HasSubstr("quaternion"))));
}

TEST_F(RosDrive, ARefusalNamesTheFirstProblem) {
  begin();
  write_colour(100'000);
  write_depth(100'000);
  write_infos();
  write_tf("colour", "depth", no_pose());
  EXPECT_THAT(refusal(), ::testing::AllOf(HasSubstr("no transform leads from colour to depth"),
                                          HasSubstr("/tf_static"), HasSubstr("quaternion")));
}

TEST_F(RosDrive, ImagesOfAnotherSizeAreLeftOutAndCounted) {
  begin();
  for (int i = 1; i < 4; ++i) write_colour(100'000 * i);
  write_depth(100'000, "colour");
  write_depth(200'000, "colour", {16, 12});
  write_depth(300'000, "colour");
  write_infos();
  RosRecording recording = open();
  int frames = 0;
  while (recording.next()) ++frames;
  EXPECT_EQ(frames, 2);
  EXPECT_THAT(recording.problems(), Contains(HasSubstr("by the calibration it must be 32x24")));
}

TEST(RosFiles, ABagThatWasNotClosedIsOne) {
  const std::string folder = ::testing::TempDir() + "ros_files_" + std::to_string(getpid());
  std::filesystem::create_directory(folder);
  for (const char* name : {"/a.bag.active", "/b.bag", "/c.mcap", "/d.active", "/e.txt"})
    std::ofstream(folder + name) << "x";
  EXPECT_THAT(ros_files(folder),
              ElementsAre(folder + "/a.bag.active", folder + "/b.bag", folder + "/c.mcap"));
  EXPECT_THAT(ros_files(folder + "/a.bag.active"), ElementsAre(folder + "/a.bag.active"));
  EXPECT_THAT(ros_files(folder + "/d.active"), IsEmpty());
  std::filesystem::remove_all(folder);
}

TEST(TransformTree, LeadsUpAndDownAndSeesWhatMoves) {
  TransformTree tree;
  tree.add({{1, "base"}, "neck", planar_pose(0, 0, M_PI / 2)});
  tree.add({{1, "neck"}, "left", moved(1, 0, 0)});
  tree.add({{1, "neck"}, "right", moved(0, 1, 0)});
  const auto found = tree.find("left", "right");
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->T_a_b.isApprox(moved(-1, 1, 0)));
  EXPECT_EQ(found->moved, 0);
  EXPECT_TRUE(tree.find("base", "left")->T_a_b.translation().isApprox(Eigen::Vector3d(0, 1, 0)));
  EXPECT_FALSE(tree.find("base", "elsewhere"));
  tree.add({{2, "base"}, "neck", planar_pose(0, 0, M_PI / 2 + 0.5)});
  EXPECT_NEAR(tree.find("base", "left")->turned, 0.5, 1e-9);
  EXPECT_EQ(tree.find("left", "right")->turned, 0);
  tree.add({{1, "left"}, "base", moved(0, 0, 0)});  // a circle ends
  EXPECT_TRUE(tree.find("base", "right"));
}

}  // namespace
}  // namespace lcmslam::ros

// Which topics of a recording are read.

#include <lcmslam/ros/topic_choice.hpp>

#include <gtest/gtest.h>

#include <lcmslam/datasets/dataset.hpp>

namespace lcmslam::ros {
namespace {

TEST(TopicChoice, TakesTheCamerasOwnImagesAndRegisteredDepth) {
  const auto image = [](const std::string& name, ImageKind kind) {
    return TopicFacts{name, "sensor_msgs/Image", 10, kind, "", {640, 480}, "f"};
  };
  std::vector<TopicFacts> topics = {image("/infra1/image", ImageKind::colour),
                                    image("/camera/color/image_raw", ImageKind::colour),
                                    image("/detector/color/debug_image", ImageKind::colour),
                                    image("/camera/depth/image_rect_raw", ImageKind::depth),
                                    image("/camera/aligned_depth_to_color/image_raw", ImageKind::depth),
                                    {"/ground_truth/odom", "nav_msgs/Odometry", 10, {}, "", {}, "base_link"},
                                    {"/slam/odom", "nav_msgs/Odometry", 10, {}, "", {}, "base_link"},
                                    {"/base/odom", "nav_msgs/Odometry", 5, {}, "", {}, "base_link"}};
  TopicChoice choice = choose_topics(topics, {});
  EXPECT_EQ(choice.topics.colour, "/camera/color/image_raw");
  EXPECT_EQ(choice.topics.depth, "/camera/aligned_depth_to_color/image_raw");
  EXPECT_EQ(choice.topics.odometry, "/base/odom");
  EXPECT_EQ(choice.topics.truth, "/ground_truth/odom");
  Topics wanted;
  wanted.colour = "/infra1/image";
  wanted.odometry = "/ground_truth/odom";
  choice = choose_topics(topics, wanted);
  EXPECT_EQ(choice.topics.colour, "/infra1/image");
  EXPECT_EQ(choice.topics.odometry, "/ground_truth/odom");
  wanted.depth = "/camera/color/image_raw";
  EXPECT_THROW(choose_topics(topics, wanted), DatasetError);
  wanted.depth = "/nowhere";
  EXPECT_THROW(choose_topics(topics, wanted), DatasetError);
}

/// Two cameras of a robot, each with depth registered to its colour; of each one image was lost.
std::vector<TopicFacts> two_cameras(const std::string& front_frame, const std::string& rear_frame) {
  const auto image = [](const std::string& name, std::int64_t messages, ImageKind kind,
                        const std::string& frame) {
    return TopicFacts{name, "sensor_msgs/Image", messages, kind, "", {640, 480}, frame};
  };
  return {image("/front/color/image_raw", 10, ImageKind::colour, front_frame),
          image("/front/aligned_depth_to_color/image_raw", 9, ImageKind::depth, front_frame),
          image("/rear/color/image_raw", 9, ImageKind::colour, rear_frame),
          image("/rear/aligned_depth_to_color/image_raw", 10, ImageKind::depth, rear_frame)};
}

TEST(TopicChoice, ColourAndDepthAreOfOneCamera) {
  for (const std::vector<TopicFacts>& topics :
       {two_cameras("front", "rear"), two_cameras("", ""), two_cameras("optical", "optical")}) {
    EXPECT_EQ(choose_topics(topics, {}).topics.colour, "/front/color/image_raw");
    EXPECT_EQ(choose_topics(topics, {}).topics.depth, "/front/aligned_depth_to_color/image_raw");
    Topics wanted;
    wanted.colour = "/rear/color/image_raw";
    EXPECT_EQ(choose_topics(topics, wanted).topics.depth, "/rear/aligned_depth_to_color/image_raw");
    wanted = {};
    wanted.depth = "/rear/aligned_depth_to_color/image_raw";
    EXPECT_EQ(choose_topics(topics, wanted).topics.colour, "/rear/color/image_raw");
  }
}

TEST(TopicChoice, DepthOfColoursFrameComesBeforeThatOfItsPath) {
  std::vector<TopicFacts> topics = two_cameras("front", "rear");
  topics[3].frame = "front";
  EXPECT_EQ(choose_topics(topics, {}).topics.depth, "/front/aligned_depth_to_color/image_raw");
  topics[1].frame = "front_depth";
  EXPECT_EQ(choose_topics(topics, {}).topics.depth, "/rear/aligned_depth_to_color/image_raw");
}

TEST(TopicChoice, ACameraWithoutDepthIsNotTaken) {
  std::vector<TopicFacts> topics = two_cameras("front", "rear");
  topics.erase(topics.begin() + 1);
  EXPECT_EQ(choose_topics(topics, {}).topics.colour, "/rear/color/image_raw");
}

// Not even where they are all there is: such poses jump whenever their map is corrected.
TEST(TopicChoice, PosesOfMapsAreNoOdometry) {
  std::vector<TopicFacts> topics = {
      {"/camera/color/image_raw", "sensor_msgs/Image", 10, ImageKind::colour, "", {640, 480}, "f"},
      {"/camera/depth/image_raw", "sensor_msgs/Image", 10, ImageKind::depth, "", {640, 480}, "f"}};
  for (const char* name :
       {"/slam/odom", "/odometry/global", "/lio_sam/mapping/odometry", "/orb_slam3/wheel_odom"})
    topics.push_back({name, "nav_msgs/Odometry", 10, {}, "", {}, "base_link"});
  EXPECT_EQ(choose_topics(topics, {}).topics.odometry, "");
  Topics wanted;
  wanted.odometry = "/slam/odom";
  EXPECT_EQ(choose_topics(topics, wanted).topics.odometry, "/slam/odom");
  topics.push_back({"/rtabmap/odom", "nav_msgs/Odometry", 10, {}, "", {}, "base_link"});
  EXPECT_EQ(choose_topics(topics, {}).topics.odometry, "/rtabmap/odom");
}

TEST(TopicChoice, KnowsWhereCameraInfoStands) {
  EXPECT_EQ(camera_info_beside("/camera/color/image_raw"), "/camera/color/camera_info");
  EXPECT_EQ(camera_info_beside("/camera/color/image_raw/compressed"), "/camera/color/camera_info");
  EXPECT_EQ(camera_info_beside("/camera/depth/image/compressedDepth"), "/camera/depth/camera_info");
}

}  // namespace
}  // namespace lcmslam::ros

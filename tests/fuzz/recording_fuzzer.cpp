// Any bytes as an MCAP file, as a bag, and as ROS's messages: refused as documented, or read, without memory
// for what lengths claim. The first byte chooses.

#include <cstdlib>

#include <lcmslam/recordings/recording_file.hpp>
#include <lcmslam/ros/images.hpp>
#include <lcmslam/ros/messages.hpp>

namespace {

using namespace lcmslam;

constexpr std::uint64_t largest_chunk = 1 << 22;  // the fuzzer may take 64 MB

const char* const types[] = {"sensor_msgs/Image",         "sensor_msgs/CompressedImage",
                             "sensor_msgs/CameraInfo",    "nav_msgs/Odometry",
                             "geometry_msgs/PoseStamped", "tf2_msgs/TFMessage",
                             "sensor_msgs/msg/Image",     "geometry_msgs/PoseWithCovarianceStamped"};

void decode(const ros::Image& image) {
  const ros::PixelCount size = ros::size_of(image);
  if (size.width * size.height > 64 * 64) return;  // larger ones are no other code
  if (ros::kind_of(image) == ros::ImageKind::depth)
    ros::to_depth(image, 1);
  else
    ros::to_colour(image, 1, 50);
}

void read_message(ByteView bytes, const std::string& written, const std::string& encoding) {
  const std::string type = ros::short_type(written);
  try {
    if (ros::is_image(type))
      decode(ros::read_image(bytes, type, encoding));
    else if (ros::is_camera_info(type))
      ros::read_camera_info(bytes, encoding);
    else if (ros::is_pose(type))
      ros::read_pose(bytes, type, encoding);
    else if (ros::is_transforms(type))
      ros::read_transforms(bytes, encoding);
  } catch (const RecordingError&) {
  } catch (const CodecError&) {
  }
}

void read_file(ByteView bytes, std::unique_ptr<RecordingFile> (*open)(ByteView, std::uint64_t)) {
  std::unique_ptr<RecordingFile> file;
  try {
    file = open(bytes, largest_chunk);
  } catch (const RecordingError&) {
    return;
  }
  std::vector<RecordedMessage> places;
  std::vector<std::size_t> sums;
  const auto sum = [](ByteView message) {
    std::size_t total = message.size;
    for (std::size_t i = 0; i < message.size; ++i) total += message.data[i];
    return total;
  };
  file->scan([&](const RecordedMessage& message, ByteView data) {
    const RecordedTopic& topic = file->topics().at(message.topic);
    read_message(data, topic.type, topic.encoding);
    if (places.size() == 100) return;
    places.push_back(message);
    sums.push_back(sum(data));
  });
  for (std::size_t i = 0; i < places.size(); ++i)  // found again where they were
    if (sum(file->read(places[i])) != sums[i]) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const ByteView bytes{data + 1, size - 1};
  const unsigned kind = data[0] % 18;
  if (kind == 0)
    read_file(bytes, open_mcap);
  else if (kind == 1)
    read_file(bytes, open_bag);
  else
    read_message(bytes, types[kind % 8], kind < 10 ? "ros1" : "cdr");
  return 0;
}

// write_reference FOLDER LOG: logs with messages of every kind, whole and damaged, and what the C++ libraries
// read in them and in LOG, as JSON: log_reader_test.py must read the same.

#include <nlohmann/json.hpp>

#include <fstream>
#include <iostream>
#include <map>

#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/parts.hpp>
#include "tests/unit/messages/samples.hpp"
#include "tools/evaluate/dense_map_log.hpp"
#include "tools/log/message_facts.hpp"
#include "tools/log/message_reader.hpp"

using namespace lcmslam;
using nlohmann::json;

namespace {

/// Tells a wrong order and a wrong value alike.
template <class Iterator>
std::int64_t checksum(Iterator begin, Iterator end) {
  std::int64_t sum = 0, weight = 0;
  for (; begin != end; ++begin) sum += static_cast<std::int64_t>(*begin) * (1 + weight++ % 65521);
  return sum;
}

json rows(const Eigen::Isometry3d& T) {
  json values;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) values.push_back(T.matrix()(row, column));
  return values;
}

json pose_of(Utime utime, const Eigen::Isometry3d& T) {
  return {{"utime", utime}, {"T", rows(T)}};
}

json camera_of(const CameraModel& c) {
  return {{"width", c.width}, {"height", c.height},        {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx},
          {"cy", c.cy},       {"distortion", c.distortion}};
}

json calibration_of(const RgbdCalibration& c) {
  return {{"sensor", c.sensor},
          {"rolling_shutter", c.rolling_shutter},
          {"colour", camera_of(c.colour)},
          {"depth", camera_of(c.depth)},
          {"T_colour_depth", rows(c.T_colour_depth)},
          {"depth_error",
           {c.depth_error.offset, c.depth_error.scale, c.depth_error.wiggle, c.depth_error.period,
            c.depth_error.phase}},
          {"depth_tilt", {c.depth_error.tilt_x, c.depth_error.tilt_y}},
          {"has_mount", c.has_mount},
          {"T_robot_camera", rows(c.T_robot_camera)},
          {"depth_max", c.depth_max}};
}

json frame_of(const EncodedFrame& encoded) {
  const RgbdFrame frame = decode(encoded);
  const bool jpeg = encoded.colour.coding == ImageCoding::jpeg;
  json result = {{"utime", frame.utime},
                 {"depth_utime", frame.depth_utime},
                 {"seq", encoded.seq},
                 {"sensor", encoded.sensor},
                 {"width", frame.colour.cols},
                 {"height", frame.colour.rows},
                 {"depth", checksum(frame.depth.begin<std::uint16_t>(), frame.depth.end<std::uint16_t>())}};
  if (jpeg) {
    result["jpeg"] = checksum(encoded.colour.bytes.begin(), encoded.colour.bytes.end());
  } else {
    std::vector<int> rgb;
    for (auto pixel = frame.colour.begin<cv::Vec3b>(); pixel != frame.colour.end<cv::Vec3b>(); ++pixel)
      for (int k = 2; k >= 0; --k) rgb.push_back((*pixel)[k]);
    result["colour"] = checksum(rgb.begin(), rgb.end());
  }
  if (!frame.amplitude.empty())
    result["amplitude"] =
        checksum(frame.amplitude.begin<std::uint8_t>(), frame.amplitude.end<std::uint8_t>());
  return result;
}

json features_of(const FeatureFrame& frame) {
  json result = {{"utime", frame.utime}, {"n", frame.features.size()}, {"fx", frame.fx}};
  for (const Feature& f : frame.features)
    result["features"].push_back({f.x, f.y, f.angle, f.point.x(), f.point.y(), f.point.z(), f.depth_sigma,
                                  f.landmark_id, checksum(f.descriptor.begin(), f.descriptor.end())});
  return result;
}

/// How many messages of each channel are whole.
json count(const std::string& file) {
  MessageReader reader(file);
  std::map<std::string, int> counts;
  while (const auto event = reader.next()) ++counts[std::string(event->channel)];
  return {{"counts", counts}, {"damages", reader.damages().size()}, {"incomplete", reader.incomplete()}};
}

/// The same, and what the messages say.
json read(const std::string& file) {
  MessageReader reader(file);
  json result = count(file);
  const auto is = [](const MessageType* type, const char* name) {
    return type != nullptr && type->name == name;
  };
  while (const auto event = reader.next()) {
    const std::string channel(event->channel);
    const MessageType* type = message_type(event->data, event->size);
    json value;
    if (is(type, "images_t"))
      value = frame_of(from_message(decode_message<images_t>(event->data, event->size)));
    else if (is(type, "camera_calibration_t"))
      value = calibration_of(from_message(decode_message<camera_calibration_t>(event->data, event->size)));
    else if (is(type, "features_t"))
      value = features_of(from_message(decode_message<features_t>(event->data, event->size)));
    else if (is(type, "ground_truth_t")) {
      const auto m = decode_message<ground_truth_t>(event->data, event->size);
      value = pose_of(m.utime, from_message(m.T_frame_child, "T"));
    } else if (is(type, "pose_estimate_t")) {
      const auto m = decode_message<pose_estimate_t>(event->data, event->size);
      value = pose_of(m.utime, from_message(m.T_map_robot, "T"));
      const Matrix6d covariance = covariance_from_message(m.covariance, "covariance");
      value["covariance"] = std::vector<double>(covariance.data(), covariance.data() + 36);
    } else if (is(type, "odometry_t")) {
      const MotionSample sample = from_message(decode_message<odometry_t>(event->data, event->size));
      value = pose_of(sample.utime, sample.T_odom_robot);
    } else if (is(type, "pose_t")) {
      const auto m = decode_message<pose_t>(event->data, event->size);
      value = pose_of(m.utime, from_message(m));
    } else if (is(type, "encoders_t")) {
      for (const Wheel& wheel : from_message(decode_message<encoders_t>(event->data, event->size)).wheels)
        value.push_back({wheel.x, wheel.y, wheel.radius, wheel.angle, wheel.steering});
    } else {
      continue;
    }
    result["channels"][channel].push_back(std::move(value));
  }
  return result;
}

template <class M>
void write(LogWriter& log, const std::string& channel, M message, std::int64_t seq) {
  message.seq = seq;
  message.sender = 5;
  log.write(1'000'000 + seq, channel, encode_message(message));
}

void write_images(LogWriter& log, Random& random) {
  EncodedFrame frame = testing::some_frame(random);
  const auto message = [&](std::int64_t seq) {
    images_t images = to_message(frame);
    set_origin(images, {seq, 5});
    return encode_message(images);
  };
  log.write(1, "CAMERA", message(41));
  frame.colour.coding = ImageCoding::raw_rgb;
  frame.colour.bytes.resize(16 * 12 * 3);
  for (std::uint8_t& byte : frame.colour.bytes) byte = static_cast<std::uint8_t>(random.below(256));
  log.write(2, "CAMERA", message(42));
  frame.colour.coding = ImageCoding::raw_bgr;
  log.write(3, "CAMERA", message(43));
  frame.colour.coding = ImageCoding::raw_gray;
  frame.colour.bytes.resize(16 * 12);
  log.write(4, "CAMERA", message(44));
  // Two of them in pieces that come mixed and not in order; of a third one piece never comes.
  const auto bytes = message(45), other = message(46);
  std::vector<part_t> pieces = split_message("CAMERA", bytes, 5, 1, 100);
  for (const part_t& piece : split_message("CAMERA", other, 6, 2, 150)) pieces.push_back(piece);
  std::swap(pieces[0], pieces[2]);
  for (const part_t& piece : split_message("CAMERA", other, 7, 3, 250)) pieces.push_back(piece);
  pieces.pop_back();
  std::int64_t seq = 0;
  for (const part_t& piece : pieces) write(log, "CAMERA_PART", piece, ++seq);
}

void write_poses(LogWriter& log, Random& random) {
  for (std::int64_t i = 0; i < 20; ++i) {
    auto estimate = make_pose_estimate(10 + i, testing::some_pose(random), testing::some_covariance(random));
    estimate.covariance[1] += 0.25;  // not symmetric
    write(log, "ICP_POSE", estimate, i);
    MotionSample sample{20 + i, testing::some_pose(random)};
    sample.covariance = testing::some_covariance(random);
    write(log, "ODOMETRY", to_message(sample, "wheels"), i);
    pose_t pose{};
    const rigid_transform_t T = to_message(testing::some_pose(random));
    pose.utime = 30 + i;
    std::copy(std::begin(T.trans), std::end(T.trans), pose.pos);
    std::copy(std::begin(T.quat), std::end(T.quat), pose.orientation);
    log.write(30 + i, "POSE_BODY", encode_message(pose));
  }
}

/// As a program of before changes were told wrote a whole graph: without the members of changes.
std::vector<std::uint8_t> former_graph(const graph_t& graph) {
  constexpr std::uint64_t fingerprint = 0x3e49193e24115fdc;
  std::vector<std::uint8_t> bytes = encode_message(graph);
  bytes.resize(bytes.size() - 9);  // change, n_gone, n_cut
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(fingerprint >> (56 - 8 * i));
  return bytes;
}

/// Keyframes 0 to 2 of two tiles each, the second published again, the third given up by the graph; before
/// them one of a mapper that ended. Then changes of the graph: 3 has moved, 4 is new, 0 is given up; one that
/// comes twice; and behind one that is missing 1 has moved, 4 is given up, and 5 is in none.
void write_map(LogWriter& log, Random& random) {
  std::int64_t seq = 0;
  const auto publish = [&](int id, std::int64_t sender, std::int64_t revision) {
    DenseKeyframe keyframe = testing::some_keyframe(random, 6000);
    keyframe.id = id;
    for (keyframe_t& tile : make_keyframe_tiles(keyframe, Eigen::Isometry3d::Identity(), revision)) {
      tile.seq = ++seq;
      tile.sender = sender;
      log.write(100 + seq, "ICP_KEYFRAME", encode_message(tile));
    }
  };
  publish(7, 4, 1);
  for (const int id : {0, 1, 2, 1}) publish(id, 5, 1 + seq);
  const auto graph = [&](const std::vector<int>& nodes, std::int8_t change, const std::vector<int>& gone) {
    graph_t message{};
    message.frame = "map";
    message.change = change;
    for (const int id : nodes) {
      graph_node_t node{};
      node.keyframe = id;
      node.T_map_camera = to_message(testing::some_pose(random));
      message.nodes.push_back(node);
    }
    message.n_nodes = static_cast<int32_t>(nodes.size());
    message.gone.assign(gone.begin(), gone.end());
    message.n_gone = static_cast<int32_t>(gone.size());
    return message;
  };
  graph_t old = graph({0, 1, 7}, 0, {});  // 7 was the ended mapper's
  old.seq = 1;
  old.sender = 5;
  log.write(1'000'000, "ICP_GRAPH", former_graph(old));
  for (const int id : {3, 4}) publish(id, 5, 1 + seq);
  const graph_t moved = graph({3, 4}, 1, {0});
  write(log, "ICP_GRAPH", moved, 2);
  write(log, "ICP_GRAPH", moved, 2);
  publish(5, 5, 1 + seq);
  write(log, "ICP_GRAPH", graph({1}, 1, {4}), 4);
}

json map_of(const std::string& file) {
  json points;
  for (const auto& point : dense_map_of(file, Eigen::Isometry3d::Identity()).points)
    points.push_back({point.point.x(), point.point.y(), point.point.z()});
  return points;
}

using Bytes = std::vector<char>;

Bytes bytes_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

/// The file without, or with other bytes at, [begin, begin + count).
void damage(const std::string& from, const std::string& to, std::size_t begin, std::size_t count,
            const char* with) {
  Bytes bytes = bytes_of(from);
  const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto end = at + static_cast<std::ptrdiff_t>(std::min(count, bytes.size() - begin));
  if (with == nullptr)
    bytes.erase(at, end);
  else
    std::fill(at, end, *with);
  std::ofstream(to, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: write_reference FOLDER LOG\n";
    return 2;
  }
  const std::string folder = std::string(argv[1]) + "/", drive = argv[2], samples = folder + "samples.lcmlog";
  std::filesystem::create_directories(folder);
  Random random(11);
  LogWriter log(samples);
  RgbdCalibration calibration = testing::some_calibration(random);
  calibration.rolling_shutter = 0.03;
  calibration.depth_error = {0.01, -0.002, 0.006, 1.9, 0.5, 0.0128, -0.0042};
  write(log, "CAMERA_CALIBRATION", to_message(calibration), 1);
  write_images(log, random);
  for (std::int64_t i = 0; i < 3; ++i)
    write(log, "FEATURES", to_message(testing::some_features(random, 50)), i);
  write_poses(log, random);
  log.write(50, "STRANGE", std::vector<std::uint8_t>(40, 7));
  write_map(log, random);
  log.close();

  json all;
  all[samples] = read(samples);
  all[samples]["cloud"] = map_of(samples);
  all[drive] = read(drive);
  // The sync word of the drive's 10th event, a stretch of 3000 bytes, lengths, the end.
  std::vector<std::uint64_t> events;
  LogReader reader(drive);
  while (const auto event = reader.next_view()) events.push_back(event->offset);
  const char zero = 0, big = 0x70;
  const auto damaged = [&](const char* name, std::uint64_t begin, std::size_t bytes, const char* with) {
    const std::string file = folder + name;
    damage(drive, file, begin, bytes, with);
    all[file] = count(file);
  };
  damaged("sync.lcmlog", events[9], 4, &zero);
  damaged("missing.lcmlog", events[20] + 10, 3000, nullptr);
  damaged("zeros.lcmlog", events[30] + 10, 3000, &zero);
  damaged("length.lcmlog", events[40] + 24, 2, &big);
  damaged("shorter.lcmlog", events[50] + 27, 1, &zero);
  damaged("payload.lcmlog", events[60] + 28 + 10, 8, &zero);
  damaged("end.lcmlog", events[events.size() - 3] + 50, 100'000'000, nullptr);
  std::ofstream(folder + "reference.json") << all;
  return 0;
}

// fuzz_seeds FOLDER: inputs of the right form for every fuzzer, one folder each.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

#include <lcmslam/command_t.hpp>
#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/log/log_format.hpp>
#include <lcmslam/map_query/question.hpp>
#include <lcmslam/map_store/file/store_codecs.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/parts.hpp>
#include <lcmslam/recordings/mcap_writer.hpp>
#include <lcmslam/ros/message_writers.hpp>
#include "tests/support/datagrams.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/messages/wire_sample.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

class SeedFolder {
 public:
  explicit SeedFolder(const fs::path& folder) : folder_(folder) {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void add(const Bytes& bytes) {
    std::ofstream file(folder_ / std::to_string(count_++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  void add(const std::string& text) { add(Bytes(text.begin(), text.end())); }

 private:
  fs::path folder_;
  int count_ = 0;
};

/// As message_fuzzer.cpp reads it: type chosen by the fingerprint in the bytes.
Bytes raw(const Bytes& message) {
  Bytes seed = {200};
  seed.insert(seed.end(), message.begin(), message.end());
  return seed;
}

template <class M>
void add_message(SeedFolder& folder, M message) {
  message.utime = 1'000'000;
  folder.add(raw(encode_message(message)));
}

void make_messages(SeedFolder folder) {
  Random random(1);
  for (const MessageType* type : MessageType::all())
    for (int i = 0; i < 2; ++i) folder.add(raw(testing::WireSampler(random).make(*type).bytes));

  EncodedFrame frame = testing::some_frame(random);
  folder.add(raw(encode_message(to_message(frame))));
  frame.colour.coding = ImageCoding::raw_bgr;
  frame.colour.bytes.resize(3 * 16 * 12);
  frame.depth.coding = ImageCoding::depth_raw;
  frame.depth.bytes.resize(2 * 8 * 6);
  folder.add(raw(encode_message(to_message(frame))));

  camera_calibration_t calibration = to_message(testing::some_calibration(random));
  calibration.seq = calibration.sender = 0;
  add_message(folder, calibration);
  encoders_t encoders = to_message(testing::some_encoders(random));
  encoders.seq = encoders.sender = 0;
  add_message(folder, encoders);
  features_t features = to_message(testing::some_features(random, 3));
  features.seq = features.sender = 0;
  add_message(folder, features);
  pose_estimate_t pose = make_pose_estimate(0, testing::some_pose(random), testing::some_covariance(random));
  pose.seq = pose.sender = 0;
  add_message(folder, pose);
  std::vector<Landmark> landmarks;
  for (int id = 0; id < 3; ++id) landmarks.push_back(testing::some_landmark(random, id));
  for (landmarks_t& tile : make_landmark_tiles(0, 2, 1, landmarks, {7})) {
    tile.seq = tile.sender = 0;
    add_message(folder, tile);
  }
  for (keyframe_t& tile :
       make_keyframe_tiles(testing::some_keyframe(random, 12), testing::some_pose(random), 1)) {
    tile.seq = tile.sender = 0;
    add_message(folder, tile);
  }
}

void make_parts(SeedFolder folder) {
  Random random(2);
  for (int i = 0; i < 10; ++i) {
    Bytes bytes(8 * 10);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.below(12));
    folder.add(bytes);
  }
}

/// Two mappers that speak by turns, with steps of a tenth of a second.
void make_sessions(SeedFolder folder) {
  for (int sender = 0; sender < 3; ++sender) {
    Bytes bytes;
    for (int i = 0; i < 100; ++i) {
      const int what = (i & 1) + 2 * sender + 8;
      bytes.push_back(static_cast<std::uint8_t>(i % 5 == 4 ? 128 + what : what));
      bytes.push_back(static_cast<std::uint8_t>(i % 5 == 4 ? i : 100));
    }
    folder.add(bytes);
  }
}

void make_configurations(SeedFolder folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(source_folder() / "config"))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    std::ifstream text(file);
    folder.add(std::string(std::istreambuf_iterator<char>(text), {}));
  }
  folder.add(std::string("icp: &a {radius: 1, numbers: [1, 2.5e3], fine: {enabled: no}}\n"
                         "camera: *a\nrooms: [{name: x}]\ninclude: other.yaml\n") +
             '\0' + "icp.fine.radius=3");
}

void make_trajectories(SeedFolder folder) {
  folder.add("# timestamp tx ty tz qx qy qz qw\n1 2 3 4 0 0 0 1\n1.5\t-2e3,0 +0 .5 .5 .5 -.5\r\n");
  Random random(3);
  Trajectory trajectory;
  for (Utime utime = 0; utime < 5'000'000; utime += 300'000)
    trajectory.push_back({utime, testing::some_pose(random)});
  std::ostringstream text;
  write_tum(text, trajectory);
  folder.add(text.str());
}

void make_logs(SeedFolder folder) {
  Random random(4);
  Bytes log;
  for (int i = 0; i < 6; ++i) {
    const std::string channel = i % 2 == 0 ? "CAMERA" : "ODOMETRY";
    const Bytes data =
        testing::WireSampler(random).make(*MessageType::all()[static_cast<std::size_t>(i)]).bytes;
    log_format::Header header;
    header.number = i;
    header.timestamp = 1000 * i;
    header.channel_size = channel.size();
    header.data_size = data.size();
    const std::size_t at = log.size();
    log.resize(at + log_format::header_size);
    log_format::write_header(log.data() + at, header);
    log.insert(log.end(), channel.begin(), channel.end());
    log.insert(log.end(), data.begin(), data.end());
    folder.add(log);
  }
  log.erase(log.begin() + 40, log.begin() + 50);  // a hole
  folder.add(log);
}

/// As nodes/requests_fuzzer.cpp reads it: the kind, then a request a line.
void make_requests(SeedFolder folder) {
  for (const char* lines :
       {"\1", "\1evening/first ply\nevening/second pcd\n", "\1../other ply\nlink ply\nfile ply\n",
        "\1a ply,pcd\nb ply\nc ply\nd ply\n", "\1link/deeper ply\n/tmp ply\n.a ply\n", "\2x\n",
        "\2{\"ask\": \"space\", \"points\": [[1, 2, 3]]}\n",
        "\2{\"ask\": \"cloud\"}\n{\"ask\": \"landmarks\"}\n"})
    folder.add(std::string(lines));
}

/// As nodes/web_fuzzer.cpp reads it: where it goes, then the bytes.
void make_web(SeedFolder folder) {
  const std::string host = " HTTP/1.1\r\nHost: localhost\r\n";
  const std::string upgrade =
      "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
      "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  const std::string raw(1, '\4'), live(1, '\1'), command(1, '\2'), text(1, '\3');
  folder.add(raw + "GET /" + host + "\r\n");
  folder.add(raw + "HEAD /index.html?token=x" + host +
             "Accept-Encoding: gzip\r\nIf-None-Match: \"a\"\r\n\r\n");
  folder.add(raw + "GET /live" + host + upgrade + "Origin: http://localhost\r\n\r\n");
  folder.add(raw + "POST /command" + host +
             "Content-Length: 3\r\nCookie: lcmslam_token_80=a; b=c\r\n\r\nabc");
  folder.add(raw + "GET /" + host + "Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n0\r\n\r\n");
  const std::string frame = std::string("\x81\x85\0\0\0\0", 6) + "{\"a\"}";
  for (const std::string& socket : {live, command}) {
    folder.add(socket + frame + frame);
    folder.add(socket + std::string("\x01\xfe\x00\x7e\1\2\3\4", 8) + std::string(126, 'x'));
    folder.add(socket + std::string("\x89\x80\0\0\0\0\x88\x82\0\0\0\0\3\xe8", 14));
  }
  for (const char* said : {R"({"got":1000})", R"({"eye":[1,2,3]})", R"({"want":["points"]})"})
    folder.add(text + said);
}

void make_questions(SeedFolder folder) {
  Box box;
  box.half_size = {1, 2, 3};
  const Points points = {{1, 2, 3}, {-0.5, 0, 1e3}};
  PlanesQuestion planes;
  planes.near = Eigen::Vector3d(1, 2, 3);
  CloudQuestion cloud;
  cloud.region.sphere = Sphere{{0, 1, 2}, 3};
  MeshQuestion mesh;
  mesh.region.from = {0, 0, 0};
  mesh.region.to = {1, 1, 1};
  for (const Question::What& what : std::initializer_list<Question::What>{
           DistanceQuestion{points}, SpaceQuestion{points}, CollisionQuestion{{Sphere{{1, 2, 3}, 4}, box}},
           CollisionQuestion{{Capsule{{1, 2, 3}, {4, 5, 6}, 7}}}, PathQuestion{box, {planar_pose(1, 2, 3)}},
           cloud, mesh, planes, ObjectsQuestion{planes}, LandmarksQuestion{}, FrontiersQuestion{},
           GridQuestion{}, LocaliseQuestion{5}})
    folder.add(to_json({what}));
}

/// As wire_fuzzer.cpp reads it: source and size before each datagram.
void make_wire(SeedFolder folder) {
  const auto datagram = [](Bytes& input, std::uint8_t source, const Bytes& bytes) {
    input.push_back(source);
    input.push_back(static_cast<std::uint8_t>(bytes.size() >> 8));
    input.push_back(static_cast<std::uint8_t>(bytes.size()));
    input.insert(input.end(), bytes.begin(), bytes.end());
  };
  const Bytes first = testing::bytes_of(std::string("CAMERA\0abcd", 11));
  Bytes whole, fragments, mixed, killing;
  datagram(whole, 0, testing::whole_datagram("CAMERA", testing::bytes_of("data")));
  datagram(whole, 1, testing::whole_datagram("UNWANTED", testing::bytes_of("data")));
  datagram(fragments, 0, testing::fragment_datagram({5, 10, 0, 0, 2}, first));
  datagram(fragments, 0, testing::fragment_datagram({5, 10, 4, 1, 2}, testing::bytes_of("efghij")));
  for (std::uint8_t source = 0; source < 6; ++source)
    datagram(mixed, source, testing::fragment_datagram({5, 12, 10, 2, 3}, testing::bytes_of("kl")));
  for (std::uint32_t sequence = 0; sequence < 6; ++sequence)
    datagram(mixed, 0, testing::fragment_datagram({sequence, 12, 4, 1, 3}, testing::bytes_of("efghij")));
  datagram(mixed, 0, testing::fragment_datagram({5, 12, 0, 0, 3}, first));
  for (const Bytes& bytes : testing::killing_datagrams("CAMERA")) datagram(killing, 0, bytes);
  for (const Bytes& input : {whole, fragments, mixed, killing}) folder.add(input);
}

void make_surf_inputs(SeedFolder folder) {
  Random random(5);
  for (int i = 0; i < 12; ++i) {
    Bytes input;
    for (int k = 0; k < 200; ++k) input.push_back(static_cast<std::uint8_t>(random.below(256)));
    folder.add(input);
  }
}

/// As store_fuzzer.cpp reads it: the kind, then the content of a blob without what seals it.
void make_store(SeedFolder folder) {
  Random random(6);
  const auto add = [&](BlobKind kind, bool packed, const Blob& blob) {
    BlobReader reader(blob, kind, packed);
    const std::size_t size = reader.left();
    const std::uint8_t* content = reader.take_bytes(size);
    Bytes seed = {static_cast<std::uint8_t>(static_cast<int>(kind) - 1)};
    seed.insert(seed.end(), content, content + size);
    folder.add(seed);
  };
  const Eigen::Isometry3d pose = testing::some_pose(random);
  StoredEdge edge;
  edge.T_from_to = pose;
  add(BlobKind::pose, false, encode_pose(pose));
  add(BlobKind::edge, false, encode_edge(edge));
  add(BlobKind::landmark, false, encode_landmark(testing::some_landmark(random, 1)));
  add(BlobKind::trajectory, true, encode_trajectory({{1, pose}, {2, pose}}));
  add(BlobKind::cloud, true, encode_cloud(testing::some_keyframe(random, 20).cloud));
  add(BlobKind::features, true, encode_features(testing::some_features(random, 3)));
  add(BlobKind::calibration, false, encode_bytes({1, 2, 3}));
  add(BlobKind::covariance, false, encode_covariance(testing::some_covariance(random)));
}

/// As recording_fuzzer.cpp reads it: what it is, then its bytes.
void make_recordings(SeedFolder folder, const fs::path& scratch) {
  const auto add = [&](std::uint8_t kind, ByteView bytes) {
    Bytes seed = {kind};
    seed.insert(seed.end(), bytes.data, bytes.data + bytes.size);
    folder.add(seed);
  };
  const Eigen::Isometry3d pose = planar_pose(1, 2, 0.3);
  const CdrWriter messages[] = {ros::write_image({1, "c"}, cv::Mat(4, 6, CV_16UC1, cv::Scalar(1500))),
                                ros::write_camera_info({1, "c"}, {6, 4, 5, 5, 3, 2, {0.1, 0, 0, 0, 0}}),
                                ros::write_pose({1, "c"}, pose),
                                ros::write_transforms({{{1, "a"}, "b", pose}})};
  const std::uint8_t kinds[] = {16, 10, 12, 13};
  for (std::size_t i = 0; i < std::size(messages); ++i) add(kinds[i], messages[i].view());
  for (const char* compression : {"", "lz4", "zstd"}) {
    const fs::path file = scratch / "seed.mcap";
    McapWriter::Options options;
    options.compression = compression;
    McapWriter writer(file.string(), options);
    const auto channel = writer.add_channel("/image", "sensor_msgs/msg/Image", "");
    writer.write(channel, 1, 1, messages[0].view());
    writer.close();
    std::ifstream stream(file, std::ios::binary);
    const Bytes bytes{std::istreambuf_iterator<char>(stream), {}};
    add(0, {bytes.data(), bytes.size()});
    fs::remove(file);
  }
  ByteWriter connection, topic, message, bag;
  using namespace std::string_view_literals;
  for (const auto field : {"op=\7"sv, "conn=\1\0\0\0"sv, "topic=/t"sv}) connection.text(field);
  topic.text("type=nav_msgs/Odometry");
  for (const auto field : {"op=\2"sv, "conn=\1\0\0\0"sv, "time=12345678"sv}) message.text(field);
  bag.raw(std::string_view("#ROSBAG V2.0\n"));
  for (const auto& [header, data] :
       {std::pair(&connection, topic.view().text()), std::pair(&message, std::string_view("text"))}) {
    bag.text(header->view().text());
    bag.text(data);
  }
  add(1, bag.view());
}

/// As bridge_fuzzer.cpp reads them: an order, whole and in pieces, twice over.
void make_bridge(SeedFolder folder) {
  command_t command{};
  command.utime = 1'000'000;
  command.name = "stop";
  command.keys = {"icp"};
  command.values = {"77"};
  command.n = 1;
  const Bytes whole = encode_message(command);
  const auto publication = [](std::uint8_t choices, const std::string& topic, const Bytes& payload) {
    Bytes bytes = {choices, static_cast<std::uint8_t>(topic.size()),
                   static_cast<std::uint8_t>(payload.size() >> 8), static_cast<std::uint8_t>(payload.size())};
    bytes.insert(bytes.end(), topic.begin(), topic.end());
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    return bytes;
  };
  for (std::uint8_t choices = 0; choices < 4; ++choices) {
    Bytes all = publication(choices, "COMMAND/key", whole);
    for (part_t& part : split_message("COMMAND", whole, 1'000'000, choices, 20)) {
      const Bytes piece = publication(choices, "COMMAND_PART", encode_message(part));
      all.insert(all.end(), piece.begin(), piece.end());
    }
    folder.add(all);
  }
  folder.add(publication(4, "lcmslam/dora/to/COMMAND", whole));
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  using namespace lcmslam;
  if (argc != 2) {
    std::cerr << "usage: fuzz_seeds FOLDER\n";
    return 2;
  }
  const fs::path folder = argv[1];
  make_messages(SeedFolder(folder / "message"));
  make_parts(SeedFolder(folder / "parts"));
  make_sessions(SeedFolder(folder / "sessions"));
  make_requests(SeedFolder(folder / "requests"));
  make_web(SeedFolder(folder / "web"));
  make_questions(SeedFolder(folder / "question"));
  make_configurations(SeedFolder(folder / "configuration"));
  make_trajectories(SeedFolder(folder / "trajectory"));
  make_logs(SeedFolder(folder / "log_reader"));
  make_wire(SeedFolder(folder / "wire"));
  make_bridge(SeedFolder(folder / "bridge"));
  make_store(SeedFolder(folder / "store"));
  make_surf_inputs(SeedFolder(folder / "surf"));
  make_recordings(SeedFolder(folder / "recording"), folder);
  return 0;
}

// The wire is frozen: a changed member makes old logs unreadable. Who must change a type gives it a
// new name; this table only grows.

#include "tests/unit/messages/all_types.hpp"

#include <cstdint>
#include <map>
#include <string>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/message_value.hpp>

namespace lcmslam {
namespace {

const std::map<std::string, std::uint64_t>& frozen() {
  static const std::map<std::string, std::uint64_t> fingerprints = {
      {"association_t", 0x013e00a33b86ef5f},
      {"associations_t", 0x606e2619df5de0e4},
      {"camera_calibration_t", 0xc046c53f42e41f11},
      {"camera_intrinsics_t", 0x7865f30ef88b1456},
      {"command_t", 0x7911011782801bc5},
      {"encoders_t", 0x5a96f5030cc7692f},
      {"feature_t", 0x9c5f47cc9d12a4ce},
      {"features_t", 0x6262ce5329c8f825},
      {"graph_covariance_t", 0xf21de20472ac0a00},
      {"graph_edge_t", 0x711c0ff514f3c5a9},
      {"graph_node_t", 0x9d48cc4afa702729},
      {"graph_t", 0x8da51a5aed0a3b66},
      {"ground_truth_t", 0xd0523560a83871d7},
      {"icp_report_t", 0x2d6935c79d4c0626},
      {"image_metadata_t", 0x9a4b634d0577fb8e},
      {"image_t", 0x14739ffe13d5f5f0},
      {"images_t", 0x20ba4f05e8f5e33a},
      {"input_status_t", 0x6f10d7a3471d3f26},
      {"keyframe_t", 0x916ee79e14f4bce0},
      {"landmark_t", 0xe6d7beaa007e99b7},
      {"landmarks_t", 0x63fd50e6bf35d9cd},
      {"map_reply_t", 0x023ace5dcb8b0610},
      {"map_request_t", 0x99db0cf62e05ed73},
      {"node_covariance_t", 0x3d9dae5e7a218d48},
      {"odometry_t", 0x5ec93350d4c4b43c},
      {"output_status_t", 0x3974a7cdb87b38ae},
      {"part_t", 0x6a6f8c93ff89b814},
      {"particle_t", 0x31beb10b9b6180e0},
      {"particles_t", 0x7c59856f0f7c81c7},
      {"pointcloud2_t", 0x0bcd5ce4bf5a1b4a},
      {"pointfield_t", 0xb24e10825e0b476d},
      {"pose_estimate_t", 0x1547952d277437bd},
      {"pose_t", 0x2e16efb052b0105e},
      {"rigid_transform_t", 0xecc586678117a361},
      {"status_t", 0x1e92269aeb92c5b9},
      {"twist_t", 0x82238d31b173d905},
      {"value_t", 0xea7bbdc5e39b2f1e},
      {"wheel_t", 0x7c8c135845c05559},
  };
  return fingerprints;
}

/// bot_core's public fingerprints (lcm-gen 1.3.1 on openhumanoids/bot_core_lcmtypes).
const std::map<std::string, std::uint64_t>& bot_core() {
  static const std::map<std::string, std::uint64_t> fingerprints = {
      {"image_metadata_t", 0x9a4b634d0577fb8e}, {"image_t", 0x14739ffe13d5f5f0},
      {"images_t", 0x20ba4f05e8f5e33a},         {"pointcloud2_t", 0x0bcd5ce4bf5a1b4a},
      {"pointfield_t", 0xb24e10825e0b476d},     {"pose_t", 0x2e16efb052b0105e}};
  return fingerprints;
}

template <class M>
class Fingerprint : public ::testing::Test {};
TYPED_TEST_SUITE(Fingerprint, testing::AllTypes);

TYPED_TEST(Fingerprint, IsFrozen) {
  const auto found = frozen().find(TypeParam::getTypeName());
  ASSERT_NE(found, frozen().end()) << "add the new type to the table";
  EXPECT_EQ(static_cast<std::uint64_t>(TypeParam::getHash()), found->second);
}

TYPED_TEST(Fingerprint, OfTheDefinitionEqualsTheGeneratedOne) {
  const MessageType* type = MessageType::find(std::string(TypeParam::getTypeName()));
  ASSERT_NE(type, nullptr);
  EXPECT_EQ(type->fingerprint, static_cast<std::uint64_t>(TypeParam::getHash()));
  EXPECT_EQ(MessageType::find(type->fingerprint), type);
}

TEST(Fingerprints, TableHoldsEveryDefinition) {
  EXPECT_EQ(MessageType::all().size(), frozen().size());
  for (const MessageType* type : MessageType::all()) EXPECT_EQ(frozen().count(type->name), 1U) << type->name;
}

// When its edges' members were called from and to, and when each message was the whole graph.
constexpr std::uint64_t former_graphs[] = {0x440ef967ce91c74a, 0x3e49193e24115fdc};
constexpr std::size_t appended = 9;  // bytes of members that came later, when they are 0

std::vector<std::uint8_t> with_fingerprint(std::vector<std::uint8_t> bytes, std::uint64_t fingerprint) {
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(fingerprint >> (56 - 8 * i));
  return bytes;
}

TEST(Fingerprints, GraphsOfOldLogsAreRead) {
  graph_t graph{};
  graph.utime = 17;
  graph.frame = "map";
  graph.n_edges = 1;
  graph.edges.resize(1);
  graph.edges[0].from_node = 3;
  graph.edges[0].to_node = 8;
  const std::vector<std::uint8_t> today = encode_message(graph);
  for (const std::uint64_t former : former_graphs) {
    ASSERT_NE(static_cast<std::uint64_t>(graph_t::getHash()), former);
    EXPECT_EQ(MessageType::find(former), MessageType::find("graph_t"));
    std::vector<std::uint8_t> bytes = with_fingerprint(today, former);
    bytes.resize(bytes.size() - appended);
    const auto read = decode_message<graph_t>(bytes.data(), bytes.size());
    EXPECT_EQ(read.utime, 17);
    EXPECT_EQ(read.edges.at(0).from_node, 3);
    EXPECT_EQ(read.edges.at(0).to_node, 8);
    EXPECT_EQ(read.change, 0);
    EXPECT_EQ(encode_message(read), today);
    const MessageValue value = read_message(*MessageType::find("graph_t"), bytes.data(), bytes.size());
    EXPECT_EQ(member(value, "utime")->integer, 17);
    EXPECT_EQ(member(value, "change")->integer, 0);
    EXPECT_THROW(decode_message<pose_t>(bytes.data(), bytes.size()), DecodeError);
  }
}

// Exactly the members that there were: neither fewer bytes nor those of today's.
TEST(Fingerprints, GraphsOfOldLogsAreReadAsTheyWere) {
  graph_t graph{};
  graph.frame = "map";
  for (const std::uint64_t former : former_graphs) {
    const std::vector<std::uint8_t> bytes = with_fingerprint(encode_message(graph), former);
    for (std::size_t size = 0; size <= bytes.size(); ++size) {
      const std::vector<std::uint8_t> part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      if (size + appended == bytes.size())
        EXPECT_NO_THROW(decode_message<graph_t>(part.data(), size));
      else
        EXPECT_THROW(decode_message<graph_t>(part.data(), size), DecodeError) << size;
    }
  }
  const std::vector<std::uint8_t> bytes = encode_message(graph);
  EXPECT_THROW(decode_message<graph_t>(bytes.data(), bytes.size() - appended), DecodeError);
}

TEST(Fingerprints, AreThoseOfBotCoreWhereWeClaimIt) {
  for (const auto& [name, fingerprint] : bot_core()) EXPECT_EQ(frozen().at(name), fingerprint) << name;
}

}  // namespace
}  // namespace lcmslam

#include "tools/echo/echo_printer.hpp"

#include <gmock/gmock.h>

#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Bytes = std::vector<std::uint8_t>;

pose_estimate_t pose() {
  pose_estimate_t message{};
  message.seq = 12;
  message.frame = "map";
  message.detail = std::string(500, 'd');
  return message;
}

std::string print(const EchoOptions& options, const std::string& channel, const Bytes& bytes) {
  return EchoPrinter(options).print(channel, bytes.data(), bytes.size()).value_or("nothing");
}

EchoOptions as_json() {
  EchoOptions options;
  options.json = true;
  return options;
}

TEST(Echo, PrintsAHeadingAndTheMembers) {
  const Bytes bytes = encode_message(pose());
  const std::string text = print({}, "ICP_POSE", bytes);
  EXPECT_THAT(text, StartsWith("ICP_POSE  pose_estimate_t, " + std::to_string(bytes.size()) + " bytes\n"));
  EXPECT_THAT(text, HasSubstr("\n  seq: 12\n"));
  EXPECT_THAT(text, HasSubstr("\n  covariance: [0, 0, 0, 0, 0, 0, ... 36 values]\n"));
  EchoOptions full;
  full.full = true;
  EXPECT_THAT(print(full, "ICP_POSE", bytes), HasSubstr("\"" + std::string(500, 'd') + "\"\n"));
}

TEST(Echo, JsonIsALineAMessage) {
  const std::string text = print(as_json(), "A \"channel\"", encode_message(pose()));
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  const auto parsed = nlohmann::json::parse(text);
  EXPECT_EQ(parsed["channel"], "A \"channel\"");
  EXPECT_EQ(parsed["type"], "pose_estimate_t");
  EXPECT_EQ(parsed["fields"]["seq"], 12);
}

TEST(Echo, SaysWhatIsWrongWithAMessage) {
  Bytes bytes = encode_message(pose());
  bytes.push_back(0);
  const std::string size = std::to_string(bytes.size());
  EXPECT_EQ(print({}, "X", bytes),
            "X  does not decode: pose_estimate_t: 1 bytes too many (" + size + " bytes)\n");
  EXPECT_EQ(nlohmann::json::parse(print(as_json(), "X", bytes))["error"],
            "pose_estimate_t: 1 bytes too many");
  EXPECT_THAT(print({}, "X", {1, 2}), HasSubstr("2 bytes are too few"));
  EXPECT_TRUE(nlohmann::json::parse(print(as_json(), "X", {1, 2}))["type"].is_null());
}

TEST(Echo, UnknownTypesAreNamedByFingerprintAndMayBeDefined) {
  const Bytes bytes = {0x89, 0xdc, 0x5b, 0x87, 0x9a, 0x50, 0x56, 0xcf, 9};
  EXPECT_EQ(print({}, "X", bytes), "X  unknown type 89dc5b879a5056cf, 9 bytes\n");
  EXPECT_EQ(nlohmann::json::parse(print(as_json(), "X", bytes))["fingerprint"], "89dc5b879a5056cf");
  EchoOptions options;
  const auto beats = parse_definitions({"package theirs; struct beat_t { int8_t n; }"});
  options.types = KnownTypes(beats);
  Bytes beat(9, 5);
  for (std::size_t i = 0; i < 8; ++i)
    beat[i] = static_cast<std::uint8_t>(beats[0]->fingerprint >> (56 - 8 * i));
  EXPECT_EQ(print(options, "X", beat), "X  theirs.beat_t, 9 bytes\n  n: 5\n");
}

TEST(Echo, PiecesArePutTogetherUnlessAskedFor) {
  const Bytes whole = encode_message(pose());
  const auto parts = split_message("POSE", whole, 0, 0, 300);
  ASSERT_GE(parts.size(), 3U);
  EchoPrinter printer{EchoOptions{}};
  for (const part_t& part : parts) {
    const Bytes bytes = encode_message(part);
    const auto text = printer.print("POSE_PART", bytes.data(), bytes.size());
    ASSERT_EQ(text.has_value(), part.part + 1 == part.n_parts);
    if (text.has_value()) {
      EXPECT_THAT(*text, StartsWith("POSE  pose_estimate_t, " + std::to_string(whole.size())));
    }
  }
  EchoOptions pieces;
  pieces.pieces = true;
  EXPECT_THAT(print(pieces, "POSE_PART", encode_message(parts[0])), StartsWith("POSE_PART  part_t, "));
  EXPECT_THAT(print({}, "OTHER_PART", encode_message(parts[0])), StartsWith("OTHER_PART  part_t, "));
}

// With LCM's own regular expressions.
std::vector<std::string> channels_heard(const std::string& pattern, const std::vector<std::string>& sent) {
  struct Ear {
    void hear(const lcm::ReceiveBuffer*, const std::string& channel) { channels.push_back(channel); }
    std::vector<std::string> channels;
  } ear;
  lcm::LCM bus("memq://");
  bus.subscribe(pattern, &Ear::hear, &ear);
  for (const std::string& channel : sent) bus.publish(channel, "x", 1);
  while (bus.handleTimeout(0) > 0) continue;
  return ear.channels;
}

TEST(Echo, PatternHoldsTheChannelsAndTheirPieces) {
  EXPECT_THAT(channels_heard(echo_pattern("A|B.*"), {"A", "AB", "B1", "A_PAR", "A_PART", "C", "B1_PART"}),
              ElementsAre("A", "B1", "A_PART", "B1_PART"));
  EXPECT_EQ(echo_pattern("A_PART"), "A_PART");
}

}  // namespace
}  // namespace lcmslam

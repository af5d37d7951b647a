#include <lcmslam/messages/print_message.hpp>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <lcmslam/images_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/status_t.hpp>
#include "tests/unit/messages/allocation_watch.hpp"
#include "tests/unit/messages/wire_sample.hpp"

namespace lcmslam {
namespace {

using testing::Bytes;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::WireSampler;
using Json = nlohmann::ordered_json;

std::vector<const MessageType*> known_types() {
  std::vector<const MessageType*> types = MessageType::all();
  types.insert(types.end(), MessageType::foreign().begin(), MessageType::foreign().end());
  return types;
}

std::string text_of(const MessageType& type, const Bytes& bytes, const MessageLimits& limits = {}) {
  return print_message(read_message(type, bytes.data(), bytes.size(), limits));
}
template <class M>
std::string text_of(const M& message, const MessageLimits& limits = {}) {
  return text_of(*MessageType::find(std::string(M::getTypeName())), encode_message(message), limits);
}
Json json_of(const MessageType& type, const Bytes& bytes, const MessageLimits& limits = {}) {
  return Json::parse(message_json(read_message(type, bytes.data(), bytes.size(), limits)));
}

std::string from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int n = 0;
  for (const char c : text.substr(0, text.find('='))) {
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    n += 6;
    if (n < 8) continue;
    n -= 8;
    bytes += static_cast<char>(bits >> n & 0xff);
  }
  return bytes;
}

/// The wire format again, from JSON and the definition.
class Encoder {
 public:
  static Bytes encode(const MessageType& type, const Json& json) {
    Encoder encoder;
    testing::put_integer(encoder.bytes_, type.fingerprint, 8);
    encoder.put(type, json);
    return encoder.bytes_;
  }

 private:
  using Kind = MessageField::Kind;
  void put(const MessageType& type, const Json& json) {
    EXPECT_EQ(json.size(), type.fields.size());
    for (const auto& field : type.fields) put(field, 0, json.at(field.name));
  }
  void put(const MessageField& field, std::size_t dimension, const Json& json) {
    const bool last = dimension + 1 == field.dimensions.size();
    if (last && field.kind == Kind::byte) {
      for (const char c : from_base64(json.get<std::string>()))
        bytes_.push_back(static_cast<std::uint8_t>(c));
    } else if (dimension < field.dimensions.size()) {
      ASSERT_TRUE(json.is_array()) << field.name;
      for (const Json& item : json) put(field, dimension + 1, item);
    } else {
      put_value(field, json);
    }
  }
  void put_value(const MessageField& field, const Json& json) {
    switch (field.kind) {
      case Kind::nested:
        return put(*field.nested, json);
      case Kind::text:
        return testing::put_text(bytes_, json.get<std::string>());
      case Kind::boolean:
        return testing::put_integer(bytes_, json.get<bool>() ? 1 : 0, 1);
      case Kind::float32:
        return put_bits<std::uint32_t>(json.get<float>());
      case Kind::float64:
        return put_bits<std::uint64_t>(json.get<double>());
      default:
        return testing::put_integer(bytes_, static_cast<std::uint64_t>(json.get<std::int64_t>()),
                                    value_size(field.kind));
    }
  }
  template <class Bits, class Real>
  void put_bits(Real value) {
    Bits bits;
    std::memcpy(&bits, &value, sizeof bits);
    testing::put_integer(bytes_, bits, sizeof bits);
  }
  Bytes bytes_;
};

TEST(PrintMessage, JsonHoldsEveryTypeWhole) {
  Random random(1);
  for (const MessageType* type : known_types()) {
    SCOPED_TRACE(display_name(*type));
    int compared = 0;
    for (int i = 0; i < 200 && compared < 20; ++i) {
      const Bytes bytes = WireSampler(random).make(*type).bytes;
      const Json json = json_of(*type, bytes, MessageLimits::none());
      if (json.dump().find("null") != std::string::npos) continue;  // random bits: NaN
      EXPECT_EQ(Encoder::encode(*type, json), bytes);
      ++compared;
    }
    EXPECT_GE(compared, 10);
  }
}

TEST(PrintMessage, TextNamesEveryMemberOfEveryType) {
  Random random(2);
  for (const MessageType* type : known_types()) {
    const std::string text = "\n" + text_of(*type, WireSampler(random).make(*type).bytes);
    for (const auto& field : type->fields)
      EXPECT_THAT(text, HasSubstr("\n" + field.name + ":")) << display_name(*type);
  }
}

TEST(PrintMessage, GarbageIsRefusedOrPrintedAndTakesLittleMemory) {
  Random random(3);
  int refused = 0, printed = 0;
  for (const MessageType* type : known_types())
    for (int i = 0; i < 300; ++i) {
      Bytes bytes = WireSampler(random).make(*type).bytes;
      for (std::uint64_t k = 1 + random.below(4); k > 0; --k) testing::mutate(bytes, random);
      bytes.shrink_to_fit();
      testing::forget_allocations();
      try {
        const MessageValue value = read_message(*type, bytes.data(), bytes.size());
        EXPECT_TRUE(Json::accept(message_json(value)));
        for (const char c : print_message(value)) EXPECT_TRUE(c == '\n' || c >= ' ' || c < 0) << int{c};
        ++printed;
      } catch (const DecodeError&) {
        ++refused;
      }
      ASSERT_LT(testing::largest_allocation(), 500 * bytes.size() + 10'000) << type->name;
    }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(printed, 1000);
}

TEST(PrintMessage, AbridgesArraysTextsAndBytes) {
  images_t images;
  images.utime = 1'262'300'000;
  images.n_images = 5;
  images.image_types = {0, 6, 100, 4, 1};
  images.images.resize(5);
  for (auto& image : images.images) {
    image.data.assign(81'234, 7);
    image.size = 81'234;
    image.width = 640;
  }
  images.images[0].nmetadata = 1;
  images.images[0].metadata = {{}};
  images.images[0].metadata[0].key = std::string(300, 'k');
  images.images[1].data = {0xff, 0xd8};
  images.images[1].size = 2;
  const std::string text = text_of(images);
  EXPECT_THAT(text, HasSubstr("utime: 1262300000\nn_images: 5\nimage_types: [0, 6, 100, 4, 1]\n"
                              "images: 5 x image_t\n  [0]\n    utime: 0\n    width: 640\n"));
  EXPECT_THAT(text, HasSubstr("    data: 81234 bytes (07 07 07 07 07 07 07 07 ...)\n"));
  EXPECT_THAT(text, HasSubstr("    data: 2 bytes (ff d8)\n"));
  EXPECT_THAT(text, HasSubstr("        key: \"" + std::string(120, 'k') + "\"... 300 bytes\n"));
  EXPECT_THAT(text, HasSubstr("    metadata: []\n"));
  EXPECT_THAT(text, HasSubstr("  ... 2 more\n"));
  EXPECT_LT(text.size(), 1200U);
  EXPECT_THAT(text_of(images, MessageLimits::none()), Not(HasSubstr("...")));

  const MessageType& type = *MessageType::find("images_t");
  const Json json = json_of(type, encode_message(images));
  EXPECT_EQ(json["images"]["length"], 5);
  EXPECT_EQ(json["images"]["first"].size(), 3U);
  EXPECT_EQ(json["images"]["first"][0]["data"]["length"], 81'234);
  EXPECT_EQ(json["images"]["first"][1]["data"], "/9g=");
}

TEST(PrintMessage, NumbersAndArraysStandBesideTheirName) {
  pose_estimate_t pose{};
  pose.sender = 0x7fffffffffffffff;
  pose.covariance[0] = 1.0 / 3;
  pose.T_map_robot.quat[0] = 1;
  pose.quality = 0.1F;
  pose.detail = "caf\xc3\xa9\n";
  const std::string text = text_of(pose);
  EXPECT_THAT(text, HasSubstr("sender: 9223372036854775807\n"));
  EXPECT_THAT(text, HasSubstr("T_map_robot:\n  trans: [0, 0, 0]\n  quat: [1, 0, 0, 0]\n"));
  EXPECT_THAT(text, HasSubstr("covariance: [0.333333, 0, 0, 0, 0, 0, ... 36 values]\n"));
  EXPECT_THAT(text, HasSubstr("quality: 0.1\n"));
  EXPECT_THAT(text, HasSubstr("detail: \"caf\xc3\xa9\\n\"\n"));
  const Json json = json_of(*MessageType::find("pose_estimate_t"), encode_message(pose));
  EXPECT_EQ(json["covariance"]["first"][0].get<double>(), 1.0 / 3);
  EXPECT_EQ(json["quality"].get<float>(), 0.1F);
  EXPECT_EQ(json["detail"], "caf\xc3\xa9\n");
}

TEST(PrintMessage, NotANumberIsNullInJson) {
  pose_estimate_t pose{};
  pose.T_map_robot.trans[0] = std::numeric_limits<double>::quiet_NaN();
  pose.T_map_robot.trans[1] = -std::numeric_limits<double>::infinity();
  EXPECT_THAT(text_of(pose), HasSubstr("trans: [nan, -inf, 0]"));
  const Json json = json_of(*MessageType::find("pose_estimate_t"), encode_message(pose));
  EXPECT_EQ(json["T_map_robot"]["trans"].dump(), "[null,null,0]");
}

TEST(PrintMessage, ArraysOfArrays) {
  const auto types = parse_definitions({"struct grid_t { int8_t n; int16_t cells[n][3]; byte rows[2][n]; }"});
  Bytes bytes;
  testing::put_integer(bytes, types[0]->fingerprint, 8);
  testing::put_integer(bytes, 4, 1);
  for (std::uint64_t k = 1; k <= 12; ++k) testing::put_integer(bytes, k, 2);
  for (std::uint64_t k = 1; k <= 8; ++k) testing::put_integer(bytes, k, 1);
  EXPECT_EQ(text_of(*types[0], bytes),
            "n: 4\ncells: [[1, 2, 3], [4, 5, 6], [7, 8, 9], ... 4 values]\n"
            "rows: [4 bytes (01 02 03 04), 4 bytes (05 06 07 08)]\n");
  EXPECT_EQ(json_of(*types[0], bytes, MessageLimits::none()).dump(),
            R"({"n":4,"cells":[[1,2,3],[4,5,6],[7,8,9],[10,11,12]],"rows":["AQIDBA==","BQYHCA=="]})");
}

TEST(PrintMessage, TextsCanDoNothingToATerminal) {
  EXPECT_EQ(quoted("\x1b[2J"), R"("\x1b[2J")");
  EXPECT_EQ(printable("a\xc2\x9b"
                      "b"),
            R"(a\xc2\x9bb)");  // C1: CSI in one character
  EXPECT_EQ(printable("\xff\xc3"), R"(\xff\xc3)");
  EXPECT_EQ(printable("\xc0\xaf \xed\xa0\x80"), R"(\xc0\xaf \xed\xa0\x80)");  // overlong, surrogate
  EXPECT_EQ(printable("\xe2\x82\xac \xf0\x9f\x98\x80"), "\xe2\x82\xac \xf0\x9f\x98\x80");
  EXPECT_EQ(json_string("\"\\\n\x01\x7f"), R"("\"\\\n\u0001\u007f")");
  for (int lead = 0; lead < 256; ++lead)
    for (int next = 0; next < 256; ++next) {
      const std::string text = {static_cast<char>(lead), static_cast<char>(next), 'x'};
      ASSERT_TRUE(Json::accept(json_string(text))) << lead << " " << next;
    }
}

TEST(PrintMessage, ATextIsCutBetweenCharacters) {
  pose_estimate_t pose{};
  MessageLimits limits;
  limits.text = 4;
  pose.detail =
      "abc\xe2\x82\xac"
      "de";
  EXPECT_THAT(text_of(pose, limits), HasSubstr("detail: \"abc\"... 8 bytes\n"));
  pose.detail = "\x80\x80\x80\x80\x80\x80\x80\x80";
  EXPECT_THAT(text_of(pose, limits), HasSubstr("... 8 bytes\n"));
}

TEST(PrintMessage, SaysWhatIsWrong) {
  Bytes bytes = encode_message(status_t{});
  bytes.pop_back();
  EXPECT_THROW(text_of(*MessageType::find("status_t"), bytes), DecodeError);
  EXPECT_THROW(text_of(*MessageType::find("images_t"), bytes), DecodeError);
}

}  // namespace
}  // namespace lcmslam

#include <gmock/gmock.h>

#include <lcmslam/recordings/byte_writer.hpp>
#include <lcmslam/recordings/compression.hpp>
#include <lcmslam/recordings/recording_file.hpp>

namespace lcmslam {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Records of a bag, or of a chunk, put together by a test.
class MadeBag {
 public:
  explicit MadeBag(std::string_view magic = "#ROSBAG V2.0\n") { bytes_.raw(magic); }

  struct Field {
    std::string name, value;
  };
  template <class T>
  static Field number(const std::string& name, T value) {
    return {name, {reinterpret_cast<const char*>(&value), sizeof value}};
  }
  static Field op(char value) { return {"op", std::string(1, value)}; }

  static std::string fields(const std::vector<Field>& list) {
    ByteWriter writer;
    for (const Field& field : list) writer.text(field.name + "=" + field.value);
    return std::string(writer.view().text());
  }
  void add(const std::vector<Field>& header, std::string_view data) {
    bytes_.text(fields(header));
    bytes_.text(data);
  }
  void add_connection(std::uint32_t id, const std::string& topic) {
    add({op(7), number("conn", id), {"topic", topic}},
        fields({{"topic", topic}, {"type", "std_msgs/String"}}));
  }
  void add_message(std::uint32_t id, const std::string& text) {
    add({op(2), number("conn", id), number("time", std::uint64_t{5} << 32 | 3)}, text);
  }
  void add_chunk(const MadeBag& content, const std::string& compression, int more = 0) {
    const auto packed = pack(compression == "none" ? "" : compression, content.view());
    add({op(5),
         {"compression", compression},
         number("size", static_cast<std::uint32_t>(content.bytes_.bytes().size()) +
                            static_cast<std::uint32_t>(more))},
        {reinterpret_cast<const char*>(packed.data()), packed.size()});
  }
  ByteView view() const { return bytes_.view(); }

 private:
  ByteWriter bytes_;
};

struct BagScan {
  std::vector<std::string> messages, damages;
};
BagScan scan_bag(ByteView bytes) {
  const auto file = open_bag(bytes);
  BagScan scanned;
  std::vector<RecordedMessage> places;
  file->scan([&](const RecordedMessage& message, ByteView text) {
    EXPECT_EQ(message.log_time, 3'000'000'005);
    places.push_back(message);
    scanned.messages.push_back(file->topics()[message.topic].name + ": " + std::string(text.text()));
  });
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_EQ(file->topics()[places[i].topic].name + ": " + std::string(file->read(places[i]).text()),
              scanned.messages[i]);
  scanned.damages = file->damages();
  return scanned;
}

MadeBag chunk_content() {
  MadeBag chunk("");
  chunk.add_connection(4, "/chatter");
  chunk.add_message(4, "hello");
  chunk.add_message(4, "you");
  return chunk;
}

TEST(Bag, GivesTheMessagesOfChunksAndOutsideOfThem) {
  MadeBag bag;
  bag.add({MadeBag::op(3), MadeBag::number("index_pos", std::uint64_t{0})}, std::string(100, ' '));
  bag.add_chunk(chunk_content(), "lz4");
  bag.add_chunk(chunk_content(), "none");
  bag.add({MadeBag::op(4), MadeBag::number("conn", 4)}, "an index");
  bag.add_message(4, "alone");
  const BagScan scanned = scan_bag(bag.view());
  EXPECT_THAT(scanned.messages, ElementsAre("/chatter: hello", "/chatter: you", "/chatter: hello",
                                            "/chatter: you", "/chatter: alone"));
  EXPECT_THAT(scanned.damages, IsEmpty());
}

TEST(Bag, CutAnywhereGivesWhatIsWholeBefore) {
  MadeBag bag;
  bag.add_chunk(chunk_content(), "none");
  bag.add_chunk(chunk_content(), "lz4");
  std::size_t most = 0;
  for (std::size_t size = 13; size < bag.view().size; ++size) {
    const BagScan scanned = scan_bag({bag.view().data, size});
    EXPECT_GE(scanned.messages.size(), most);
    most = scanned.messages.size();
  }
  EXPECT_EQ(most, 2U);
}

TEST(Bag, ChunksThatAreDamagedAreNamedAndTheRestStays) {
  MadeBag bag;
  bag.add_chunk(chunk_content(), "lz4", 1);
  bag.add({MadeBag::op(5), {"compression", "xz"}, MadeBag::number("size", 3)}, "abc");
  bag.add({MadeBag::op(5), {"compression", "bz2"}, MadeBag::number("size", 3)}, "abc");
  bag.add({MadeBag::op(5), {"compression", "none"}, MadeBag::number("size", 0xffffffffU)}, "abc");
  bag.add({MadeBag::op(5), {"compression", "none"}}, "abc");
  bag.add({}, "abc");
  bag.add_chunk(chunk_content(), "none");
  const BagScan scanned = scan_bag(bag.view());
  EXPECT_THAT(scanned.messages, ElementsAre("/chatter: hello", "/chatter: you"));
  EXPECT_THAT(scanned.damages,
              ElementsAre(HasSubstr("it is said to hold"), HasSubstr("'xz' is not known"),
                          HasSubstr("compressed bytes are damaged"), HasSubstr("a chunk of 4294967295 bytes"),
                          HasSubstr("without the field size"), HasSubstr("without the field op")));
}

TEST(Bag, MessagesWithoutConnectionAndEncryptionAreSaid) {
  MadeBag bag;
  bag.add({MadeBag::op(3), {"encryptor", "rosbag/AesCbcEncryptor"}}, "");
  bag.add_message(9, "whose?");
  EXPECT_THAT(scan_bag(bag.view()).damages, ElementsAre(HasSubstr("encrypted by rosbag/AesCbcEncryptor"),
                                                        HasSubstr("that nothing describes")));
}

TEST(Bag, OtherVersionsAreRefusedWithTheirCure) {
  const MadeBag old("#ROSBAG V1.2\n");
  try {
    open_bag(old.view());
    FAIL();
  } catch (const RecordingError& error) {
    EXPECT_THAT(error.what(), HasSubstr("rosbag migrates"));
  }
}

}  // namespace
}  // namespace lcmslam

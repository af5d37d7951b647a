#include <gmock/gmock.h>

#include <unistd.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include <lcmslam/recordings/compression.hpp>
#include <lcmslam/recordings/mcap_format.hpp>
#include <lcmslam/recordings/mcap_writer.hpp>
#include <lcmslam/recordings/recording_file.hpp>

namespace lcmslam {
namespace {

using mcap::Record;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;
using Bytes = std::vector<std::uint8_t>;

ByteView view(const Bytes& bytes) {
  return {bytes.data(), bytes.size()};
}

struct Scanned {
  std::vector<std::string> messages;  // "/topic: text"
  std::vector<std::string> damages;
};

Scanned scan(const Bytes& bytes, std::uint64_t largest_chunk = usual_largest_chunk) {
  const auto file = open_mcap(view(bytes), largest_chunk);
  std::vector<RecordedMessage> places;
  Scanned scanned;
  file->scan([&](const RecordedMessage& message, ByteView text) {
    places.push_back(message);
    scanned.messages.push_back(file->topics()[message.topic].name + ": " + std::string(text.text()));
  });
  for (std::size_t i = 0; i < places.size(); ++i)  // read once more, where it was
    EXPECT_EQ(file->topics()[places[i].topic].name + ": " + std::string(file->read(places[i]).text()),
              scanned.messages[i]);
  scanned.damages = file->damages();
  return scanned;
}

/// Two topics, three messages in each of two chunks.
Bytes written(const std::string& compression) {
  const std::string file = ::testing::TempDir() + "recordings_" + std::to_string(getpid()) + ".mcap";
  McapWriter::Options options;
  options.compression = compression;
  options.chunk_size = 1000;
  McapWriter writer(file, options);
  const auto a = writer.add_channel("/a", "std_msgs/msg/A", "string text\n");
  const auto b = writer.add_channel("/b", "std_msgs/msg/A", "string text\n");
  for (int i = 0; i < 6; ++i) {
    const std::string text = std::to_string(i) + std::string(300, 'x');
    writer.write(i % 2 == 0 ? a : b, 100 + i, 90 + i,
                 {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  writer.close();
  std::ifstream stream(file, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(stream), {}};
  std::filesystem::remove(file);
  return bytes;
}

TEST(McapWriter, ALinkIsNeitherFollowedNorReplaced) {
  const std::string link = ::testing::TempDir() + "recordings_" + std::to_string(getpid()) + ".link";
  std::filesystem::create_symlink("nowhere", link);
  try {
    McapWriter writer(link, McapWriter::Options{});
    ADD_FAILURE() << "it is written";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(link + ": cannot be written: is a symbolic link"));
  }
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  std::filesystem::remove(link);
}

/// A file of records that a test puts together.
class MadeFile {
 public:
  MadeFile() { bytes_.raw(mcap::magic); }
  void add(Record kind, const ByteWriter& content, std::optional<std::uint64_t> size = {}) {
    bytes_.number(kind);
    bytes_.number(size.value_or(content.bytes().size()));
    bytes_.raw(content.view());
  }
  void add_chunk(const std::string& compression, std::uint64_t size, const Bytes& packed,
                 std::uint32_t crc = 0) {
    ByteWriter chunk;
    chunk.number(std::uint64_t{1});
    chunk.number(std::uint64_t{2});
    chunk.number(size);
    chunk.number(crc);
    chunk.text(compression);
    chunk.number(static_cast<std::uint64_t>(packed.size()));
    chunk.raw(view(packed));
    add(Record::chunk, chunk);
  }
  const Bytes& bytes() const { return bytes_.bytes(); }

 private:
  ByteWriter bytes_;
};

class McapOfEachCompression : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, McapOfEachCompression, ::testing::Values("", "lz4", "zstd"));

TEST_P(McapOfEachCompression, ComesBackAsItWasWritten) {
  const Scanned scanned = scan(written(GetParam()));
  ASSERT_THAT(scanned.messages, SizeIs(6));
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(scanned.messages[i],
              (i % 2 == 0 ? "/a: " : "/b: ") + std::to_string(i) + std::string(300, 'x'));
  EXPECT_THAT(scanned.damages, IsEmpty());
}

TEST_P(McapOfEachCompression, CutAnywhereGivesTheWholeChunksBeforeAndSaysSo) {
  const Bytes whole = written(GetParam());
  std::size_t most = 0;
  for (std::size_t size = mcap::magic.size(); size + mcap::magic.size() + 29 < whole.size(); size += 7) {
    const Scanned scanned = scan({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_GE(scanned.messages.size(), most) << size;
    most = scanned.messages.size();
    EXPECT_THAT(scanned.damages, SizeIs(1)) << size;
  }
  EXPECT_EQ(most, 6U);
}

TEST(Mcap, AFlippedBitOfAChunkLosesThatChunkAlone) {
  Bytes bytes = written("");
  const std::string text(bytes.begin(), bytes.end());
  bytes[text.find("1xxx") + 5] ^= 1U;  // in the first one, which describes the topics, as the summary does
  const Scanned scanned = scan(bytes);
  EXPECT_THAT(scanned.messages, ElementsAre(StartsWith("/b: 3"), StartsWith("/a: 4"), StartsWith("/b: 5")));
  EXPECT_THAT(scanned.damages, Contains(HasSubstr("they do not have its CRC")));
  EXPECT_THAT(scanned.damages, Contains(HasSubstr("the data up to here are damaged")));
}

TEST(Mcap, AFlippedBitOfTheSummaryIsSaid) {
  Bytes bytes = written("zstd");
  const std::string text(bytes.begin(), bytes.end());
  bytes[text.rfind("/a") + 1] ^= 1U;
  const Scanned scanned = scan(bytes);
  EXPECT_THAT(scanned.messages, SizeIs(6));
  EXPECT_THAT(scanned.damages, ElementsAre(HasSubstr("the summary is damaged")));
}

TEST(Mcap, AbsurdLengthsAreRefusedBeforeMemoryIsTaken) {
  MadeFile record;
  record.add(Record::message, {}, 1ULL << 63);
  EXPECT_THAT(scan(record.bytes()).damages, ElementsAre(HasSubstr("a record ends behind the file")));
  MadeFile chunk;
  chunk.add_chunk("zstd", 1ULL << 40, {1, 2, 3});
  EXPECT_THAT(scan(chunk.bytes()).damages, Contains(HasSubstr("a chunk of 1099511627776 bytes")));
  MadeFile text;
  ByteWriter schema;
  schema.number(std::uint16_t{1});
  schema.number(std::uint32_t{0xffffffff});
  text.add(Record::schema, schema);
  EXPECT_THAT(scan(text.bytes()).damages,
              Contains(HasSubstr("4294967295 bytes are said to follow, but only 0")));
}

TEST(Mcap, ChunksThatHoldMoreOrLessThanTheySayAreRefused) {
  const Bytes zeros(100'000);
  for (const char* compression : {"lz4", "zstd"}) {
    const Bytes packed = pack(compression, view(zeros));
    MadeFile more, less;
    more.add_chunk(compression, 50'000, packed);
    EXPECT_THAT(scan(more.bytes()).damages, Contains(HasSubstr("more bytes come out"))) << compression;
    less.add_chunk(compression, 200'000, packed);
    EXPECT_THAT(scan(less.bytes()).damages, Contains(HasSubstr("it is said to hold 200000"))) << compression;
  }
}

TEST(Mcap, AnUnknownCompressionIsNamed) {
  MadeFile file;
  file.add_chunk("brotli", 3, {1, 2, 3});
  EXPECT_THAT(scan(file.bytes()).damages, Contains(HasSubstr("'brotli' is not known: must be lz4, zstd")));
}

TEST(Mcap, AMessageOfAnUndescribedChannelIsCounted) {
  MadeFile file;
  ByteWriter message;
  message.number(std::uint16_t{7});
  message.raw(std::string_view("12345678901234567890xyz"));
  file.add(Record::message, message);
  EXPECT_THAT(scan(file.bytes()).damages, Contains(HasSubstr("a channel that nothing describes")));
}

TEST(Mcap, OtherFilesAreRefused) {
  const Bytes text = {'h', 'e', 'l', 'l', 'o', ' ', 'y', 'o', 'u'};
  EXPECT_THROW(open_mcap(view(text)), RecordingError);
}

TEST(Crc32, IsThatOfTheCheckValue) {
  const std::string digits = "123456789";
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(digits.data());
  EXPECT_EQ(crc32({bytes, 9}), 0xCBF43926U);
  EXPECT_EQ(crc32({bytes + 4, 5}, crc32({bytes, 4})), 0xCBF43926U);
  EXPECT_EQ(crc32({}, 0xCBF43926U), 0xCBF43926U);
}

}  // namespace
}  // namespace lcmslam

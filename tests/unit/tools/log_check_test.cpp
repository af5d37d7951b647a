#include "tools/log/log_check.hpp"

#include <gmock/gmock.h>

#include <set>

#include <lcmslam/geometry/random.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/log_samples.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;

class LogCheckTest : public ::testing::Test {
 protected:
  LogCheck check(const std::function<void(LogWriter&)>& write) {
    const std::string file = (folder_.path() / "checked.lcmlog").string();
    LogWriter log(file);
    write(log);
    log.close();
    return check_log(file);
  }
  ScratchFolder folder_;
};

TEST_F(LogCheckTest, SoundLogIsClean) {
  const LogCheck result = check_log(sample_log(folder_, 3));
  EXPECT_TRUE(result.findings.empty());
  EXPECT_EQ(result.events, 3 + 150 + 30 + 6);
  EXPECT_EQ(result.unknown_types, 6);
  EXPECT_EQ(result.sessions, 1);
}

TEST_F(LogCheckTest, ForeignTypesAreJudgedByTheirDefinitions) {
  const auto types =
      read_definitions({folder_.write("beat_t.lcm", "struct beat_t { int64_t utime; int8_t n; }").string()});
  Bytes beat(17, 0);
  for (std::size_t i = 0; i < 8; ++i)
    beat[i] = static_cast<std::uint8_t>(types[0]->fingerprint >> (56 - 8 * i));
  beat[13] = 0x10;  // a utime of about 1 s
  Bytes cut = beat;
  cut.pop_back();
  Bytes late = beat;
  late[12] = 1;  // 16.777 s later
  const std::string file = (folder_.path() / "beats.lcmlog").string();
  LogWriter log(file);
  for (const Bytes& bytes : {beat, cut, beat, late}) log.write(sample_start, "BEAT", bytes);
  log.close();

  const LogCheck blind = check_log(file);
  EXPECT_EQ(blind.unknown_types, 4);
  EXPECT_THAT(blind.unknown_channels, ::testing::ElementsAre("BEAT"));
  EXPECT_TRUE(blind.findings.empty());
  const LogCheck result = check_log(file, KnownTypes(types));
  EXPECT_EQ(result.unknown_types, 0);
  ASSERT_EQ(result.findings.size(), 2U);
  EXPECT_THAT(result.findings[0].text, HasSubstr("not what its type says"));
  EXPECT_THAT(result.findings[1].text, HasSubstr("utime jumps by 16.777"));
}

TEST_F(LogCheckTest, DefinitionsAreFilesOrFoldersAndErrorsNameThem) {
  std::filesystem::create_directories(folder_.path() / "types/deep");
  folder_.write("types/outer_t.lcm", "package a; struct outer_t { deep.inner_t inner; }");
  folder_.write("types/deep/inner_t.lcm", "package deep; struct inner_t { int8_t n; }");
  EXPECT_EQ(read_definitions({(folder_.path() / "types").string()}).size(), 2U);
  EXPECT_GT(read_definitions({source_folder() / "lcmtypes"}).size(), 40U)
      << "two packages with types of one name";
  std::filesystem::create_directories(folder_.path() / "empty");
  for (const auto& [path, text] :
       {std::pair("empty", "has no .lcm file"), std::pair("types/outer_t.lcm", "inner_t")}) {
    try {
      read_definitions({(folder_.path() / path).string()});
      ADD_FAILURE() << path;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(text));
    }
  }
}

TEST_F(LogCheckTest, SessionsInOneFileAreNoFault) {
  sample_log(folder_, 2, "a");
  folder_.write("both", folder_.read("a") + folder_.read("a"));
  const LogCheck result = check_log((folder_.path() / "both").string());
  EXPECT_TRUE(result.findings.empty());
  EXPECT_EQ(result.sessions, 2);
}

TEST_F(LogCheckTest, DamageIsFoundAtItsPlace) {
  const std::string file = sample_log(folder_, 3);
  const std::uint64_t size = std::filesystem::file_size(file);
  LogReader reader(file);
  std::uint64_t offset = 0;
  for (int i = 0; i < 20; ++i) offset = reader.next_view()->offset;
  damage(file, offset);  // the sync word of event 19
  const LogCheck result = check_log(file);
  ASSERT_EQ(result.findings.size(), 1U);
  EXPECT_EQ(result.findings[0].offset, offset);
  EXPECT_THAT(format_finding(result.findings[0]), HasSubstr("(1 events lost)"));
  std::filesystem::resize_file(file, size - 1);
  EXPECT_EQ(check_log(file).findings.size(), 2U);
}

TEST_F(LogCheckTest, MessageOfAKnownTypeMustFitItsDefinition) {
  const LogCheck result = check([](LogWriter& log) {
    Bytes cut = encoders_message(sample_start, 0);
    cut.pop_back();
    log.write(sample_start, "ENCODERS", encoders_message(sample_start, 0));
    log.write(sample_start, "ENCODERS", cut);
    log.write(sample_start, "ENCODERS", encoders_message(sample_start, 1));
  });
  ASSERT_EQ(result.findings.size(), 1U);
  EXPECT_THAT(result.findings[0].text, AllOf(HasSubstr("event 1"), HasSubstr("not what its type says")));
}

TEST_F(LogCheckTest, DisorderAndClocksThatJump) {
  const LogCheck result = check([](LogWriter& log) {
    log.write(2'000'000, "ENCODERS", encoders_message(2'000'000, 0));
    log.write(1'700'000, "ENCODERS", encoders_message(1'700'000, 1));   // earlier
    log.write(2'100'000, "ENCODERS", encoders_message(80'000'000, 2));  // 78 s ahead of the log
    log.write(2'200'000, "ENCODERS", encoders_message(-5, 3));          // no time
    log.write(2'300'000, "CAMERA_CALIBRATION", calibration_message(0, 0));
    log.write(2'400'000, "CAMERA_CALIBRATION", calibration_message(2'400'000, 1));
  });
  ASSERT_EQ(result.findings.size(), 3U);
  EXPECT_THAT(format_finding(result.findings[0]),
              AllOf(HasSubstr("event 1"), HasSubstr("ENCODERS"), HasSubstr("0.300000 s before")));
  EXPECT_THAT(result.findings[1].text, HasSubstr("utime jumps by 77.9"));
  EXPECT_THAT(result.findings[2].text, HasSubstr("utime -5"));
  EXPECT_EQ(result.findings[2].number, 3);
}

// lcm-logger mixes up the order of messages that come nearly together.
TEST_F(LogCheckTest, ALittleDisorderIsCountedAndNoFinding) {
  const LogCheck result = check([](LogWriter& log) {
    log.write(2'000'000, "ENCODERS", encoders_message(2'000'000, 0));
    log.write(1'999'800, "ENCODERS", encoders_message(2'000'100, 1));
    log.write(2'100'000, "ENCODERS", encoders_message(2'100'000, 2));
    log.write(2'000'000, "ENCODERS", encoders_message(2'100'100, 3));
  });
  EXPECT_TRUE(result.findings.empty());
  EXPECT_EQ(result.jittered, 2);
  EXPECT_EQ(result.largest_jitter, 100'000);
}

TEST_F(LogCheckTest, MissingEventNumbersAreFound) {
  const std::string file = sample_log(folder_, 1);
  LogReader reader(file);
  std::vector<std::uint64_t> offsets;
  while (const auto event = reader.next_view()) offsets.push_back(event->offset);
  const std::string bytes = folder_.read("a.lcmlog");
  folder_.write("cut", bytes.substr(0, offsets[10]) + bytes.substr(offsets[13]));
  const LogCheck result = check_log((folder_.path() / "cut").string());
  ASSERT_EQ(result.findings.size(), 1U);
  EXPECT_EQ(result.findings[0].number, 13);
  EXPECT_THAT(result.findings[0].text, HasSubstr("follows event number 9"));
}

TEST_F(LogCheckTest, PiecesThatAreMissingOrContradictEachOther) {
  const LogCheck result = check([](LogWriter& log) {
    write_pieces(log, sample_start, "CAMERA", camera_message(sample_start, 0), 0);
    write_pieces(log, sample_start, "CAMERA", camera_message(sample_start, 1), 1, 0);
    part_t bad = split_message("CAMERA", Bytes(100), sample_start, 2, 50).front();
    bad.part = 9;
    log.write(sample_start, "CAMERA_PART", encode_message(bad));
    Bytes wrong = camera_message(sample_start, 3);
    wrong.pop_back();  // whole pieces of a message that is not
    write_pieces(log, sample_start, "CAMERA", wrong, 3);
  });
  ASSERT_EQ(result.findings.size(), 3U);
  EXPECT_THAT(result.findings[0].text, HasSubstr("part 9 of 2"));
  EXPECT_THAT(result.findings[1].text, HasSubstr("not what its type says"));
  EXPECT_THAT(format_finding(result.findings[2]), HasSubstr("CAMERA: 1 messages in pieces are incomplete"));
}

TEST_F(LogCheckTest, ContentThatTheNodesWouldRefuseIsFound) {
  const LogCheck result = check([](LogWriter& log) {
    log.write(sample_start, "CAMERA_CALIBRATION", calibration_message(sample_start, 0));
    log.write(sample_start, "CAMERA", camera_message(sample_start, 0));
    log.write(sample_start, "CAMERA", camera_message(sample_start, 1, 0, 200));  // another camera's
    images_t colour_only;
    const Bytes both = camera_message(sample_start, 2);
    colour_only = decode_message<images_t>(both.data(), both.size());
    colour_only.images.pop_back();
    colour_only.image_types.pop_back();
    colour_only.n_images = 1;
    log.write(sample_start, "CAMERA", encode_message(colour_only));
    pose_estimate_t pose{};  // a quaternion of zeros
    pose.utime = sample_start;
    log.write(sample_start, "ICP_POSE", encode_message(pose));
    camera_calibration_t calibration{};
    calibration.utime = sample_start;
    log.write(sample_start, "CAMERA_CALIBRATION", encode_message(calibration));
    write_pieces(log, sample_start, "CAMERA", encode_message(colour_only), 3);
  });
  ASSERT_EQ(result.findings.size(), 5U);
  EXPECT_THAT(format_finding(result.findings[0]), AllOf(HasSubstr("event 2"), HasSubstr("would be refused"),
                                                        HasSubstr("200x1"), HasSubstr("300x1")));
  EXPECT_THAT(result.findings[1].text, HasSubstr("no depth image"));
  EXPECT_THAT(result.findings[2].text, HasSubstr("quaternion"));
  EXPECT_EQ(result.findings[3].channel, "CAMERA_CALIBRATION");
  EXPECT_THAT(result.findings[4].text, HasSubstr("no depth image")) << "in pieces, too";
}

TEST_F(LogCheckTest, FlippedBitsInImagesAreFound) {
  std::string bytes;
  {
    std::ifstream kitchen(source_folder() / "logs/kitchen.lcmlog", std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(kitchen), {});
  }
  EXPECT_TRUE(check_log(folder_.write("sound", bytes).string()).findings.empty());
  Random random(1);
  for (int i = 0; i < 300; ++i) bytes[random.below(bytes.size())] ^= static_cast<char>(1 << random.below(8));
  const LogCheck result = check_log(folder_.write("flipped", bytes).string());
  std::set<std::string> channels;
  for (const LogFinding& finding : result.findings)
    if (finding.text.find("would be refused") != std::string::npos) channels.insert(finding.channel);
  EXPECT_GT(result.findings.size(), 20U) << "of 40 frames, which hold nearly all of the bytes";
  EXPECT_THAT(channels, ::testing::Contains("CAMERA"));
}

TEST_F(LogCheckTest, WhatIsNoLogIsAnError) {
  EXPECT_THROW(check_log((folder_.path() / "none").string()), std::runtime_error);
  EXPECT_THROW(check_log(folder_.write("text", "no log").string()), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam

// Camera data from logs, whole or in pieces, once or several times over.

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/parts.hpp>
#include "procs/camera/camera_log.hpp"
#include "procs/camera/repeated_source.hpp"
#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

const std::string kitchen = source_folder() / "logs/kitchen.lcmlog";

class CameraLog : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "lcmslam-camera-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

struct Frame {
  Utime utime, depth_utime;
  std::vector<std::uint8_t> colour, depth;
  bool operator==(const Frame& o) const {
    return utime == o.utime && depth_utime == o.depth_utime && colour == o.colour && depth == o.depth;
  }
};

std::vector<Frame> frames_of(CameraSource& source) {
  std::vector<Frame> frames;
  while (const auto event = source.next())
    if (const auto* f = std::get_if<EncodedFrame>(&*event))
      frames.push_back({f->utime, f->depth.utime, f->colour.bytes, f->depth.bytes});
  return frames;
}

TEST_F(CameraLog, PiecesAreReadLikeWholeImages) {
  const std::string pieces = folder_ / "pieces.lcmlog";
  LogReader reader(kitchen);
  LogWriter writer(pieces);
  std::int64_t message = 0;
  while (const auto event = reader.next()) {
    if (event->channel != "CAMERA") {
      writer.write(event->timestamp, event->channel, event->data);
      continue;
    }
    for (const part_t& part : split_message("CAMERA", event->data, event->timestamp, message, 30'000))
      writer.write(event->timestamp, "CAMERA_PART", encode_message(part));
    ++message;
  }
  writer.close();
  const auto whole = open_log(kitchen), split = open_log(pieces);
  EXPECT_EQ(whole->frames(), 40U);
  EXPECT_EQ(split->frames(), 40U);
  const auto expected = frames_of(*whole);
  EXPECT_EQ(expected.size(), 40U);
  EXPECT_TRUE(frames_of(*split) == expected);
  EXPECT_EQ(split->malformed(), 0U);
}

TEST_F(CameraLog, OdometryThatIsNotPlayedIsNamed) {
  const std::string imported = folder_ / "imported.lcmlog";
  LogReader reader(kitchen);
  LogWriter writer(imported);
  while (const auto event = reader.next())
    writer.write(event->timestamp, event->channel == "ENCODERS" ? "TWIST" : event->channel, event->data);
  writer.close();
  EXPECT_THAT(open_log(kitchen)->notes(), ::testing::SizeIs(1));
  EXPECT_THAT(open_log(imported)->notes(),
              ::testing::ElementsAre(::testing::HasSubstr("40 frames"),
                                     ::testing::HasSubstr(" TWIST are not played; `lcmslam log play`")));
}

TEST_F(CameraLog, RepeatedPassesGoOnInTime) {
  const auto source = repeat_source([] { return open_log(kitchen); }, 3);
  EXPECT_EQ(source->frames(), 120U);
  const auto once = frames_of(*open_log(kitchen));
  const auto thrice = frames_of(*source);
  ASSERT_EQ(thrice.size(), 3 * once.size());
  for (std::size_t i = 1; i < thrice.size(); ++i) EXPECT_GT(thrice[i].utime, thrice[i - 1].utime);
  for (std::size_t i = 0; i < thrice.size(); ++i) {
    const Frame& like = once[i % once.size()];
    EXPECT_EQ(thrice[i].colour, like.colour);
    EXPECT_EQ(thrice[i].depth_utime - thrice[i].utime, like.depth_utime - like.utime);
  }
}

/// Gives the wheels' readings, and no frame.
class WithoutFrames : public CameraSource {
 public:
  explicit WithoutFrames(std::unique_ptr<CameraSource> source) : source_(std::move(source)) {}
  const RgbdCalibration& calibration() const override { return source_->calibration(); }
  std::size_t frames() const override { return 0; }
  std::vector<std::string> warnings() const override { return {"7 times, first rgb/1.png: is missing"}; }
  std::optional<CameraEvent> next() override {
    auto event = source_->next();
    while (event && std::holds_alternative<EncodedFrame>(*event)) event = source_->next();
    return event;
  }

 private:
  std::unique_ptr<CameraSource> source_;
};

TEST_F(CameraLog, WhatFailsLeavesTheFileAsItWas) {
  const auto content = [&] {
    std::ostringstream text;
    text << std::ifstream(folder_ / "old.lcmlog").rdbuf();
    return text.str();
  };
  std::ofstream(folder_ / "old.lcmlog") << "precious";
  const std::string file = folder_ / "old.lcmlog";
  try {
    WithoutFrames source(open_log(kitchen));
    write_log(source, file);
    ADD_FAILURE() << "a log without frames was written";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(),
                ::testing::AllOf(::testing::HasSubstr(file), ::testing::HasSubstr("rgb/1.png")));
  }
  int events = 0;
  const auto stop = [&] {
    if (++events == 100) throw std::runtime_error("stopped");
  };
  EXPECT_THROW(write_log(*open_log(kitchen), file, stop), std::runtime_error);
  EXPECT_EQ(content(), "precious");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1) << "a part file stays";
}

TEST_F(CameraLog, WhatCannotBePlayedIsNamed) {
  const std::string empty = folder_ / "empty.lcmlog";
  LogWriter writer(empty);
  writer.write(1, "ENCODERS", std::vector<std::uint8_t>{1, 2, 3});
  writer.close();
  for (const std::string& file : {empty, (folder_ / "missing.lcmlog").string()}) try {
      open_log(file);
      ADD_FAILURE() << file;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(file));
    }
}

}  // namespace
}  // namespace lcmslam

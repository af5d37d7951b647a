// What batch settles before any work: frames, calibration, and where odometry comes from.

#include "tools/batch/batch_plan.hpp"

#include <gmock/gmock.h>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/runtime/options.hpp>
#include "procs/odometry/odometry_settings.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/log_samples.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ConfigNode replay(const std::vector<std::string>& overrides = {}) {
  return load_config(source_folder() / "config/replay.yaml", overrides);
}

/// A log with images and their calibration, and with messages on these channels.
LogOffer offer(const std::map<std::string, std::string>& more) {
  LogOffer offer;
  offer.calibrated = true;
  offer.messages = {{"CAMERA", 40}, {"CAMERA_CALIBRATION", 4}};
  for (const auto& [channel, type] : more) {
    offer.messages[channel] = 100;
    offer.by_type[type].insert(channel);
  }
  return offer;
}

OdometryNodeSettings odometry(const BatchPlan& plan) {
  return read_settings<OdometryNodeSettings>(plan.config.section("odometry"));
}

std::string error_of(const ConfigNode& config, const LogOffer& offer) {
  try {
    plan_batch(config, "my.lcmlog", offer, false);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(BatchPlan, TakesTheBestOdometryThatTheLogHasAndSaysWhy) {
  const std::map<std::string, std::string> wheels = {{"ENCODERS", "encoders_t"}},
                                           pose = {{"POSE_BODY", "pose_t"}},
                                           both = {{"ENCODERS", "encoders_t"}, {"POSE_BODY", "pose_t"}};
  const auto plan_of = [](const auto& channels) {
    return plan_batch(replay(), "my.lcmlog", offer(channels), false);
  };
  EXPECT_EQ(odometry(plan_of(both)).source, "wheels");
  EXPECT_THAT(plan_of(wheels).notes, ElementsAre("odometry: wheels, from ENCODERS"));
  EXPECT_EQ(odometry(plan_of(pose)).source, "external");
  EXPECT_THAT(plan_of(pose).notes,
              ElementsAre("odometry: external, from POSE_BODY; the log has no ENCODERS, TWIST"));
  const BatchPlan visual = plan_of(std::map<std::string, std::string>());
  EXPECT_EQ(odometry(visual).source, "visual");
  EXPECT_THAT(
      visual.notes,
      ElementsAre("odometry: visual, from the camera's features; the log has no ENCODERS, TWIST, POSE_BODY"));
  EXPECT_EQ(visual.frames, 40);
}

TEST(BatchPlan, ThePoseOfAnyNameIsTakenWhenItIsTheOnlyOne) {
  const BatchPlan plan = plan_batch(replay(), "my.lcmlog", offer({{"VICON \"x\"", "pose_t"}}), false);
  EXPECT_EQ(odometry(plan).source, "external");
  EXPECT_EQ(odometry(plan).external_channel, "VICON \"x\"");
  const BatchPlan two = plan_batch(replay(), "my.lcmlog", offer({{"A", "pose_t"}, {"B", "pose_t"}}), false);
  EXPECT_EQ(odometry(two).source, "visual");
}

TEST(BatchPlan, ImagesOfAnyNameAreTakenWhenTheyAreTheOnlyOnes) {
  LogOffer foreign;
  foreign.messages = {{"MULTISENSE", 30}};
  foreign.by_type = {{"images_t", {"MULTISENSE"}}};
  const BatchPlan plan = plan_batch(replay(), "my.lcmlog", foreign, true);
  EXPECT_EQ(plan.camera, "MULTISENSE");
  EXPECT_EQ(plan.frames, 30);
  EXPECT_THAT(plan.notes, ::testing::Contains("images: from MULTISENSE, the log's only images_t"));
}

TEST(BatchPlan, ANamedSourceThatTheLogLacksIsRefusedWithTheCure) {
  EXPECT_THAT(error_of(replay({"odometry.source=wheels"}), offer({{"POSE_BODY", "pose_t"}})),
              AllOf(HasSubstr("my.lcmlog: has no ENCODERS"), HasSubstr("odometry.source=wheels"),
                    HasSubstr("odometry.source=auto"), HasSubstr("POSE_BODY (pose_t)")));
  EXPECT_THAT(error_of(replay({"odometry.source=external"}), offer({{"MY_POSE", "pose_t"}})),
              HasSubstr("has no POSE_BODY"));
  EXPECT_EQ(error_of(replay({"odometry.source=visual"}), offer({{"ENCODERS", "encoders_t"}})), "");
}

TEST(BatchPlan, ImagesWithoutCalibrationAreRefusedWithTheCure) {
  LogOffer uncalibrated = offer({});
  uncalibrated.calibrated = false;
  EXPECT_THAT(error_of(replay(), uncalibrated),
              AllOf(HasSubstr("my.lcmlog: has no CAMERA_CALIBRATION"), HasSubstr("--calibration FILE"),
                    HasSubstr("lcmslam log calibrate")));
  EXPECT_EQ(plan_batch(replay(), "my.lcmlog", uncalibrated, true).frames, 40);
}

TEST(BatchPlan, AForeignLogIsRefusedAndItsChannelsAreNamed) {
  LogOffer foreign;
  foreign.messages = {{"LEFT_HEAD", 3}, {"RIGHT_HEAD", 3}, {"SCAN", 7}};
  foreign.by_type = {{"images_t", {"LEFT_HEAD", "RIGHT_HEAD"}}};
  EXPECT_THAT(error_of(replay(), foreign),
              AllOf(HasSubstr("my.lcmlog: has no CAMERA (images_t)"),
                    HasSubstr("it has LEFT_HEAD (images_t), RIGHT_HEAD (images_t), SCAN")));
  LogOffer features = offer({});  // images, where features are asked for
  EXPECT_THAT(error_of(load_config(source_folder() / "config/mrclam.yaml", {}), features),
              HasSubstr("has no FEATURES (features_t)"));
}

TEST(LogOfferTest, CountsWhatLiesWithinTheSpan) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "a.lcmlog").string();
  LogWriter log(file);
  write_sample(log, 4);
  pose_t pose{};
  log.write(sample_start + 2'500'000, "VICON", encode_message(pose));
  write_pieces(log, sample_start + 3'000'000, "CAMERA", camera_message(sample_start, 1), 1);
  log.close();
  const LogOffer middle = read_offer(file, {2, 3});
  EXPECT_EQ(middle.messages.at("ENCODERS"), 51);  // both ends belong to it
  EXPECT_EQ(middle.messages.at("CAMERA"), 10 + 1);
  EXPECT_THAT(middle.by_type.at("pose_t"), ElementsAre("VICON"));
  EXPECT_TRUE(middle.calibrated);
  EXPECT_THAT(middle.listed(), HasSubstr("VICON (pose_t)"));
  EXPECT_FALSE(read_offer(file, {0, 1}).has("VICON"));
}

TEST(LogOfferTest, ACalibrationFromBeforeTheSpanCounts) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "a.lcmlog").string();
  LogWriter log(file);
  log.write(sample_start, "CAMERA_CALIBRATION", calibration_message(sample_start, 0));
  log.write(sample_start + 5'000'000, "CAMERA", camera_message(sample_start, 0));
  log.write(sample_start + 9'000'000, "CAMERA_CALIBRATION", calibration_message(sample_start, 1));
  log.close();
  EXPECT_TRUE(read_offer(file, {4, 6}).calibrated);
  EXPECT_THAT(read_offer(file, {6, 0}).messages, ::testing::SizeIs(1));
  LogWriter late(file);
  late.write(sample_start, "CAMERA", camera_message(sample_start, 0));
  late.write(sample_start + 9'000'000, "CAMERA_CALIBRATION", calibration_message(sample_start, 1));
  late.close();
  EXPECT_FALSE(read_offer(file, {0, 6}).calibrated);
}

}  // namespace
}  // namespace lcmslam

// Lost and found: cameras that see nothing or nonsense, and a robot that is carried while its wheels stand
// still. Whoever is lost says so within a second, maps no nonsense, and is found again within three in a
// mapped place.

#include <gmock/gmock.h>

#include <iostream>

#include <lcmslam/map_store/file/map_file.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/lost_drive.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using testing::LostDrive;
using testing::RecordedDrive;
using testing::value_of;

// s after the first part's begin: where the robot is again on its way of the beginning, and until when it is
// so.
constexpr double mapped_again = 20;
const std::string both_poses[] = {"FASTSLAM_POSE", "ICP_POSE"};

const LostDrive& as_it_was() {
  static const LostDrive drive({});
  return drive;
}

std::string text(const std::optional<double>& seconds) {
  return seconds ? std::to_string(*seconds).substr(0, 4) + " s" : "-";
}

void print(const char* name, const LostDrive& drive, double begin, double end) {
  const LostDrive& usual = as_it_was();
  for (const std::string& channel : both_poses) {
    std::cout << "| " << name << " | " << channel << " | " << text(drive.told_after(channel, begin)) << " | "
              << text(drive.found_after(channel, end)) << " | " << drive.rms(channel, end + 2) << " | "
              << usual.rms(channel, end + 2) << " |\n";
  }
  const auto landmarks = drive.landmarks(), keyframes = drive.keyframes();
  std::cout << "  " << landmarks.wrong << " of " << landmarks.all << " landmarks wrong, " << keyframes.wrong
            << " of " << keyframes.all << " nodes; maps " << value_of(drive.fastslam, "sessions") << ", "
            << value_of(drive.icp, "sessions") << "\n";
}

/// Nothing in the map is more wrong than without the disturbance.
void expect_no_nonsense(const LostDrive& drive, const std::string& frame = "map") {
  const auto usual = as_it_was().landmarks(), landmarks = drive.landmarks(frame);
  EXPECT_GT(landmarks.all, 100);
  EXPECT_LE(landmarks.wrong * usual.all, 1.2 * usual.wrong * landmarks.all + 3 * usual.all);
  const auto keyframes = drive.keyframes(frame);
  EXPECT_GT(keyframes.all, 3);
  EXPECT_EQ(keyframes.wrong, 0);
}

LostDrive spoiled(double seconds, const std::function<void(RgbdFrame&)>& spoil) {
  LostDrive::Plan plan;
  plan.spoil = [=](RgbdFrame& frame, double now) {
    if (now >= mapped_again - seconds && now < mapped_again) spoil(frame);
  };
  return LostDrive(plan);
}

/// The same with other draws of the particles, which decide as much as what happened: RMS over all.
double rms_over_draws(const LostDrive& drive, double from) {
  double squares = std::pow(drive.rms("FASTSLAM_POSE", from), 2);
  constexpr int draws = 3;
  for (int seed = 2; seed <= draws; ++seed) {
    LostDrive::Plan plan = drive.plan();
    plan.seed = seed;
    squares += std::pow(LostDrive(plan).rms("FASTSLAM_POSE", from), 2);
  }
  return std::sqrt(squares / draws);
}

/// Whoever was lost errs at most twice as much as without it.
void expect_half_as_good_afterwards(const LostDrive& drive) {
  constexpr double from = mapped_again + 2;
  static const double usual = rms_over_draws(as_it_was(), from);
  const double fastslam = rms_over_draws(drive, from);
  std::cout << "  FASTSLAM_POSE over three draws " << fastslam << " | " << usual << "\n";
  EXPECT_LE(fastslam, 2 * usual);
  EXPECT_LE(drive.rms("ICP_POSE", from), 2 * as_it_was().rms("ICP_POSE", from));
}

struct WhoIsLost {
  bool fastslam, icp;
};

/// Who is lost by it says so and is found; who is not lost needs to be no worse.
void expect_lost_and_found(const char* name, const LostDrive& drive, double seconds, WhoIsLost told) {
  print(name, drive, mapped_again - seconds, mapped_again);
  for (const std::string& channel : both_poses) {
    SCOPED_TRACE(channel);
    if (channel == "ICP_POSE" ? told.icp : told.fastslam) {
      EXPECT_LE(drive.told_after(channel, mapped_again - seconds).value_or(99), 1);
    }
    EXPECT_LE(drive.found_after(channel, mapped_again).value_or(99), 3);
  }
  expect_half_as_good_afterwards(drive);
  EXPECT_EQ(value_of(drive.fastslam, "sessions"), 1);
  EXPECT_EQ(value_of(drive.icp, "sessions"), 1);
  expect_no_nonsense(drive);
}

TEST(LostAndFound, CameraCovered) {
  expect_lost_and_found("covered",
                        spoiled(5,
                                [](RgbdFrame& frame) {
                                  frame.colour.setTo(cv::Scalar::all(0));
                                  frame.depth.setTo(0);
                                }),
                        5, {true, true});
}

TEST(LostAndFound, ConstantImages) {
  expect_lost_and_found("constant",
                        spoiled(5,
                                [](RgbdFrame& frame) {
                                  frame.colour.setTo(cv::Scalar::all(90));
                                  frame.depth.setTo(2000);
                                }),
                        5, {true, true});
}

TEST(LostAndFound, ConstantDepth) {
  expect_lost_and_found("constant depth", spoiled(5, [](RgbdFrame& frame) { frame.depth.setTo(1500); }), 5,
                        {true, true});
}

TEST(LostAndFound, DepthOnly) {
  expect_lost_and_found("depth only",
                        spoiled(10, [](RgbdFrame& frame) { frame.colour.setTo(cv::Scalar::all(0)); }), 10,
                        {true, false});
}

TEST(LostAndFound, ColourOnly) {
  expect_lost_and_found("colour only", spoiled(10, [](RgbdFrame& frame) { frame.depth.setTo(0); }), 10,
                        {true, true});
}

// In the bend: uncovered, it sees what it has not seen before, and odometry leads on, in the same map.
TEST(LostAndFound, CameraCoveredUntilTheMapHasEnded) {
  LostDrive::Plan plan;
  plan.spoil = [](RgbdFrame& frame, double now) {
    if (now < 8 || now >= 13) return;
    frame.colour.setTo(cv::Scalar::all(0));
    frame.depth.setTo(0);
  };
  const LostDrive drive(plan);
  print("covered until the map has ended", drive, 8, 13);
  for (const std::string& channel : both_poses)
    EXPECT_LE(drive.told_after(channel, 8).value_or(99), 1) << channel;
  EXPECT_EQ(value_of(drive.fastslam, "sessions"), 1);
  EXPECT_EQ(value_of(drive.icp, "sessions"), 1);
}

/// Wheels that turn for nothing, 0.1 m in radius.
LostDrive slipping(double metres, double begin, double end) {
  LostDrive::Plan plan;
  plan.slip = [=](double now) { return metres / 0.1 * std::clamp((now - begin) / (end - begin), 0.0, 1.0); };
  return LostDrive(plan);
}

/// What is seen overrules the wheels: who claims to be tracked is, and as well as without.
void expect_overruled(const char* name, const LostDrive& drive, double begin, double end) {
  print(name, drive, begin, end);
  for (const std::string& channel : both_poses) {
    SCOPED_TRACE(channel);
    for (const auto& m : drive.poses(channel)) {
      if (!LostDrive::claims(m)) continue;
      EXPECT_LT(drive.error_of(m, channel), 0.1) << drive.seconds_of(m.utime);
    }
    EXPECT_LE(drive.found_after(channel, end).value_or(99), 1);
    EXPECT_LE(drive.rms(channel, end + 2), 2 * as_it_was().rms(channel, end + 2));
  }
  EXPECT_EQ(value_of(drive.fastslam, "sessions"), 1);
  EXPECT_EQ(value_of(drive.icp, "sessions"), 1);
  expect_no_nonsense(drive);
}

TEST(LostAndFound, WheelsThatSpin) {
  expect_overruled("slip", slipping(0.5, 12, 13), 12, 13);
}
TEST(LostAndFound, WheelsThatAreStuck) {
  expect_overruled("stuck", slipping(-0.5, 4, 6), 4, 6);
}

// A processor that is busy otherwise gets to every second image for five seconds, and to none for two of
// them.
TEST(LostAndFound, ABusyProcessor) {
  LostDrive::Plan plan;
  plan.taken = [](int image, double now) {
    return now < 3 || now >= 8 || (image % 2 == 0 && (now < 5 || now >= 7));
  };
  expect_overruled("busy", LostDrive(plan), 3, 8);
}

// From its way after the bend back to the first metres of it.
TEST(LostAndFound, CarriedToAMappedPlace) {
  LostDrive::Plan plan;
  plan.parts = {{RecordedDrive::moves, 16}, {3, 10}};
  const LostDrive drive(plan);
  const double carried = drive.begin_of(1);
  print("carried to a mapped place", drive, carried, carried);
  for (const std::string& channel : both_poses) {
    SCOPED_TRACE(channel);
    EXPECT_LE(drive.told_after(channel, carried).value_or(99), 1);
    EXPECT_LE(drive.found_after(channel, carried).value_or(99), 3);
    EXPECT_LE(drive.rms(channel, carried + 3), 2 * as_it_was().rms(channel, 0, 8));
  }
  EXPECT_EQ(value_of(drive.fastslam, "sessions"), 1);
  EXPECT_EQ(value_of(drive.icp, "sessions"), 1);
  expect_no_nonsense(drive);
  // A controller has not seen it jump: half a metre a second, and three sigmas of a step.
  const auto local = drive.bus.on<pose_estimate_t>("ICP_LOCAL_POSE");
  ASSERT_GT(local.size(), 50U);
  for (std::size_t i = 1; i < local.size(); ++i)
    EXPECT_LT(distance_between(from_message(local[i - 1].T_map_robot, "pose"),
                               from_message(local[i].T_map_robot, "pose")),
              0.5e-6 * static_cast<double>(local[i].utime - local[i - 1].utime) + 0.12)
        << i;
}

// A gap in all that is heard, and then a place that it has not seen, with good wheels.
TEST(LostAndFound, BackInANewPlaceAfterAGap) {
  LostDrive::Plan plan;
  plan.parts = {{0, 7}, {12, RecordedDrive::ends}};
  plan.pause = 4;
  plan.new_map_after = 3;
  const LostDrive drive(plan);
  const double back = drive.begin_of(1);
  print("back in a new place", drive, back, back);
  const std::string channel = "FASTSLAM_POSE";
  double heard_again = 0;
  for (const auto& m : drive.poses(channel)) {
    const double seconds = drive.seconds_of(m.utime);
    if (seconds < back) continue;
    EXPECT_EQ(m.status, pose_estimate_t::LOST) << seconds;
    if (heard_again == 0) heard_again = seconds;
  }
  EXPECT_EQ(value_of(drive.fastslam, "sessions"), 2);
  EXPECT_EQ(drive.bus.on<pose_estimate_t>(channel).back().frame, "map-2");
  EXPECT_EQ(drive.bus.on<pose_estimate_t>(channel).back().status, pose_estimate_t::TRACKING);
  EXPECT_LE(drive.rms(channel, 0, 1e9, "map-2"), 0.05);
  EXPECT_NEAR(drive.seconds_of(drive.poses(channel, "map-2").at(0).utime) - heard_again, plan.new_map_after,
              0.5);
}

// It sees what it has not seen, maps that beside the old map, and at the end comes by where it began.
TEST(LostAndFound, CarriedToANewPlaceThatLeadsToTheOldOne) {
  LostDrive::Plan plan;
  plan.parts = {{0, 7}, {12, RecordedDrive::ends}};
  const LostDrive drive(plan);
  const double carried = drive.begin_of(1);
  print("carried to a new place", drive, carried, carried);
  for (const std::string& channel : both_poses) {
    SCOPED_TRACE(channel);
    EXPECT_LE(drive.told_after(channel, carried).value_or(99), 1);
    EXPECT_THAT(drive.bus.on<pose_estimate_t>(channel).back().frame, "map-2");
    EXPECT_LE(drive.rms(channel, 0, 1e9, "map-2"), 0.05);
  }
  expect_no_nonsense(drive);
  expect_no_nonsense(drive, "map-2");

  // The map server joins both.
  testing::ScratchFolder folder;
  testing::TestBus server;
  const auto& map = server.add<MapServerNode>(ConfigNode::parse(
      "{folder: " + folder.path().string() + ", layers: {make: false, background: false}}"));
  for (const auto& message : drive.bus.published())
    server.deliver(message.channel, message.bytes), server.work();
  for (int i = 0; i < 50; ++i) server.work();
  EXPECT_EQ(value_of(map, "sessions_joined"), 1);
  server.finish();
  const auto sessions = MapFile(folder.path() / "map.lcmslam").sessions();
  // FastSLAM's map has few landmarks there and may stay apart; what is joined must be right.
  bool dense_joined = false;
  for (const auto& session : sessions) {
    if (session.state != SessionState::joined) continue;
    dense_joined |= session.mapper == "icp";
    const std::string channel = session.mapper == "icp" ? "ICP_POSE" : "FASTSLAM_POSE";
    const Eigen::Isometry3d right =
        drive.T_world_map(channel).inverse() * drive.T_world_map(channel, session.frame);
    std::cout << session.mapper << " joined " << distance_between(*session.T_map_session, right) << " m and "
              << angle_between(*session.T_map_session, right) << " rad from the truth\n";
    EXPECT_LT(distance_between(*session.T_map_session, right), 0.05);
    EXPECT_LT(angle_between(*session.T_map_session, right), 0.02);
  }
  EXPECT_TRUE(dense_joined);
}

}  // namespace
}  // namespace lcmslam

// `calibrate tof --live` and `calibrate pair --live`, while somebody holds a board before a running head.

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"
#include "tests/support/board_shots.hpp"

namespace lcmslam::integration {
namespace {

using ::testing::HasSubstr;

constexpr int places = 18;

/// A head on the bus, and a board before it.
class HeldBoard {
 public:
  explicit HeldBoard(const RgbdCalibration& told) : told_(told) {}

  /// In one place, until the command has taken a view of it or looked at it often enough.
  void hold(int place, const Program& command) {
    Random random(7, static_cast<std::uint64_t>(place));
    testing::BoardPlaces near_to_far;
    const double share = 0.9 / (1 + 2.5 * place / places);
    near_to_far.near = share, near_to_far.far = 0.92 * share, near_to_far.middle = 1 - share;
    near_to_far.tilt = 0.5;
    const Eigen::Isometry3d T = near_to_far(place, board_, truth.calibration.depth, random);
    RgbdFrame frame;
    frame.amplitude = amplitude_(T, random);
    frame.depth = testing::board_depth(board_, truth, T, random);
    cv::cvtColor(colour_(truth.calibration.T_colour_depth * T, random), frame.colour, cv::COLOR_GRAY2BGR);
    constexpr int looks = 4;
    const std::string taken = fmt_views(views_ + 1);
    for (int look = 0; look < (views_ == 0 ? 40 : looks) && !command.wrote(taken); ++look) {
      utime_ += 300'000;  // the command looks at four images a second
      frame.utime = frame.depth_utime = utime_;
      EncodedFrame encoded = encode(frame, 95);
      encoded.sensor = "held";
      bus_.publish("CAMERA_CALIBRATION", to_message(told_));
      bus_.publish("CAMERA", to_message(encoded));
      wait_until([&] { return command.wrote(taken); }, 1);
    }
    if (command.wrote(taken)) ++views_;
  }
  int views() const { return views_; }

  const testing::RgbdTruth truth = testing::drawn_head(3);

 private:
  static std::string fmt_views(int n) { return std::to_string(n) + (n == 1 ? " view" : " views"); }

  RgbdCalibration told_;
  Board board_ = testing::large_board();
  testing::BoardRenderer colour_{board_, truth.calibration.colour, {0.6, 2.5, 2}};
  testing::BoardRenderer amplitude_{board_, truth.calibration.depth, {0.5, 3, 4}};
  Bus bus_;
  Utime utime_ = 1'000'000;
  int views_ = 0;
};

std::vector<std::string> calibrate(const std::string& what, const std::string& out,
                                   const std::vector<std::string>& more) {
  std::vector<std::string> words = {"lcmslam", "calibrate", what,       "--live", "--columns", "8",
                                    "--rows",  "7",         "--square", "80",     "-o",        out};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Holds the board everywhere and ends the command as its user does.
RgbdCalibration calibrated_live(const std::string& what, const RgbdCalibration& told, const std::string& out,
                                const std::vector<std::string>& more) {
  HeldBoard held(told);
  Program command(calibrate(what, out, more));
  for (int place = 0; place < places && command.running(); ++place) held.hold(place, command);
  command.send(SIGINT);
  EXPECT_EQ(command.wait(60).exit_code, 0) << command.output();
  EXPECT_GE(held.views(), 8) << command.output();
  return load_calibration(out);
}

TEST(CalibrateLive, TofAndPairFromARunningHead) {
  TemporaryFolder folder;
  const testing::RgbdTruth truth = testing::drawn_head(3);
  const RgbdCalibration& c = truth.calibration;
  RgbdCalibration start = c;
  start.depth.fx *= 1.03, start.depth.fy *= 1.03;
  start.T_colour_depth.translation().x() += 0.02;
  start.depth_error = {};
  const std::string tof = folder / "tof.yaml", pair = folder / "pair.yaml";

  const RgbdCalibration of_tof = calibrated_live("tof", start, tof, {"--accept"});
  EXPECT_NEAR(of_tof.depth.fx, c.depth.fx, 0.003 * c.depth.fx);
  EXPECT_TRUE(of_tof.colour == c.colour) << "what the running head says";

  const RgbdCalibration of_pair = calibrated_live("pair", start, pair, {"--into", tof});
  EXPECT_LT(distance_between(of_pair.T_colour_depth, c.T_colour_depth), 0.003);
  EXPECT_LT(angle_between(of_pair.T_colour_depth, c.T_colour_depth), 0.2 * M_PI / 180);
}

TEST(CalibrateLive, SaysThatNoCameraRuns) {
  TemporaryFolder folder;
  const Result result = run(calibrate("tof", folder / "tof.yaml", {"--seconds", "1"}), 60);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("is a camera running?"));
}

}  // namespace
}  // namespace lcmslam::integration

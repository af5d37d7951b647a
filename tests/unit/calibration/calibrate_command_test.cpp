// The command as a user runs it, on folders of rendered images.

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/calibration_text.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tests/support/board_shots.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/calibrate/recorded_drive.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

testing::CommandRun calibrate(std::vector<std::string> arguments) {
  return testing::run_command({"calibrate", calibrate_command}, std::move(arguments));
}

std::string name_of_shot(int i) {
  return "shot" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png";
}

/// A folder of images of the usual board before a camera.
void write_images(const fs::path& folder, const CameraModel& camera, int count,
                  const testing::BoardPlaces& places) {
  const Board board;
  const testing::BoardRenderer render(board, camera, {0.6, 2.5, 2});
  Random random(5);
  fs::create_directories(folder);
  for (int i = 0; i < count; ++i)
    cv::imwrite((folder / name_of_shot(i)).string(), render(places(i, board, camera, random), random));
}

TEST(CalibrateCommand, PrintsABoard) {
  const testing::ScratchFolder scratch;
  const std::string svg = (scratch.path() / "board.svg").string(),
                    png = (scratch.path() / "board.png").string();
  const auto run = calibrate({"board", svg, "--board", "checkerboard", "--columns", "8", "--square", "80"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(scratch.read("board.svg"), HasSubstr("checkerboard 8 x 7, squares of 80 mm"));
  EXPECT_EQ(calibrate({"board", png}).exit_code, 0);
  EXPECT_TRUE(find_board(cv::imread(png, cv::IMREAD_GRAYSCALE), Board()))
      << "what is printed is what is found";
  EXPECT_EQ(calibrate({"board", png}).exit_code, 1) << "replaces nothing unasked";
  EXPECT_THAT(calibrate({"board", (scratch.path() / "board.pdf").string()}).errors,
              HasSubstr(".svg or .png"));
}

TEST(CalibrateCommand, CameraWritesACalibrationAndHowSureItIs) {
  const testing::ScratchFolder scratch;
  const CameraModel truth = testing::drawn_colour_camera(8);
  write_images(scratch.path() / "images", truth, 14, {});
  scratch.write("images/notes.txt", "no image");
  const std::string out = (scratch.path() / "head.yaml").string();
  const auto run = calibrate({"camera", (scratch.path() / "images").string(), "-o", out, "--pictures",
                              (scratch.path() / "report").string()});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.errors;
  EXPECT_THAT(run.out, HasSubstr("14 images"));
  const RgbdCalibration found = load_calibration(out);
  EXPECT_EQ(found.sensor, "head");
  EXPECT_NEAR(found.colour.fx, truth.fx, 0.004 * truth.fx);
  const ConfigNode covariance = ConfigNode::load(scratch.path() / "head_covariance.yaml");
  EXPECT_EQ(covariance.text("of"), "colour");
  EXPECT_EQ(covariance.get("values", std::vector<std::string>{}).front(), "fx");
  EXPECT_FALSE(cv::imread((scratch.path() / "report/coverage.png").string()).empty());
  EXPECT_FALSE(cv::imread((scratch.path() / "report/residuals.png").string()).empty());
}

TEST(CalibrateCommand, ABadSetIsRefusedAndNothingIsWritten) {
  const testing::ScratchFolder scratch;
  testing::BoardPlaces middle;  // never beside the middle
  middle.middle = 0.05, middle.near = 0.4, middle.far = 0.3;
  write_images(scratch.path() / "images", testing::drawn_colour_camera(9), 9, middle);
  const std::string out = (scratch.path() / "head.yaml").string();
  const auto run = calibrate({"camera", (scratch.path() / "images").string(), "-o", out});
  EXPECT_EQ(run.exit_code, 1) << run.out << run.errors;
  EXPECT_THAT(run.out, HasSubstr("missing: no corners in the image's upper left corner"));
  EXPECT_FALSE(fs::exists(out));
  EXPECT_FALSE(fs::exists(scratch.path() / "head_covariance.yaml"));
}

TEST(CalibrateCommand, WithoutABoardItSaysWhatMayBeWrong) {
  const testing::ScratchFolder scratch;
  fs::create_directories(scratch.path() / "images");
  for (int i = 0; i < 3; ++i)
    cv::imwrite((scratch.path() / "images" / name_of_shot(i)).string(),
                cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)));
  const auto run =
      calibrate({"camera", (scratch.path() / "images").string(), "-o", (scratch.path() / "o.yaml").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, HasSubstr("too few views of the board"));
}

/// A large board before both cameras of a head: the folders colour, amplitude and depth.
void write_shots(const fs::path& shots, const testing::RgbdTruth& truth) {
  const RgbdCalibration& c = truth.calibration;
  const Board board = testing::large_board();
  const testing::BoardRenderer colour(board, c.colour, {0.6, 2.5, 2}), amplitude(board, c.depth, {0.5, 3, 4});
  Random random(3);
  for (const char* folder : {"colour", "amplitude", "depth"}) fs::create_directories(shots / folder);
  constexpr int count = 18;
  for (int i = 0; i < count; ++i) {
    testing::BoardPlaces places;
    const double share = 0.9 / (1 + 2.5 * i / count);
    places.near = share, places.far = 0.92 * share, places.middle = 1 - share, places.tilt = 0.5;
    const Eigen::Isometry3d T = places(i, board, c.depth, random);
    cv::imwrite((shots / "colour" / name_of_shot(i)).string(), colour(c.T_colour_depth * T, random));
    cv::imwrite((shots / "amplitude" / name_of_shot(i)).string(), amplitude(T, random));
    cv::imwrite((shots / "depth" / name_of_shot(i)).string(), testing::board_depth(board, truth, T, random));
  }
}

testing::CommandRun with_large_board(std::vector<std::string> arguments) {
  for (const char* word : {"--columns", "8", "--rows", "7", "--square", "80"}) arguments.emplace_back(word);
  return calibrate(std::move(arguments));
}

TEST(CalibrateCommand, TofAndPairFromAFolderOfShots) {
  const testing::ScratchFolder scratch;
  const testing::RgbdTruth truth = testing::drawn_head(3);
  const RgbdCalibration& c = truth.calibration;
  const fs::path shots = scratch.path() / "shots";
  write_shots(shots, truth);
  // The start: 3 % and 2 cm off, no error of the ranges known.
  RgbdCalibration start = c;
  start.depth.fx *= 1.03, start.depth.fy *= 1.03;
  start.T_colour_depth.translation().x() += 0.02;
  start.depth_error = {};
  const std::string rough = scratch.write("rough.yaml", calibration_text(start)).string();
  const std::string tof = (scratch.path() / "tof.yaml").string(),
                    pair = (scratch.path() / "pair.yaml").string();
  // A whole checkerboard does not reach the corners of an image of so few pixels.
  const auto run = with_large_board({"tof", shots.string(), "-o", tof, "--into", rough, "--accept"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.errors;
  EXPECT_THAT(run.out, HasSubstr("wiggle"));
  const RgbdCalibration of_tof = load_calibration(tof);
  EXPECT_NEAR(of_tof.depth.fx, c.depth.fx, 0.003 * c.depth.fx);
  for (double r = 1; r < 2.4; r += 0.1)
    EXPECT_NEAR(of_tof.depth_error.at(r), c.depth_error.at(r), 0.005) << r;

  const auto second = with_large_board({"pair", shots.string(), "-o", pair, "--into", tof});
  ASSERT_EQ(second.exit_code, 0) << second.out << second.errors;
  const RgbdCalibration of_pair = load_calibration(pair);
  EXPECT_LT(distance_between(of_pair.T_colour_depth, c.T_colour_depth), 0.003);
  EXPECT_LT(angle_between(of_pair.T_colour_depth, c.T_colour_depth), 0.2 * M_PI / 180);
  EXPECT_TRUE(of_pair.colour == c.colour) << "other values stay";
  EXPECT_THAT(second.out, Not(HasSubstr("(depth_error) stays")));
  for (double r = 1; r < 2.4; r += 0.1)
    EXPECT_NEAR(of_pair.depth_error.at(r), c.depth_error.at(r), 0.003) << r;
}

// Somebody's hand is before the board when it stands still for the first time: the next shots of that place
// count.
TEST(CalibrateCommand, APlaceThatColourDidNotSeeIsLookedAtAgain) {
  const testing::ScratchFolder scratch;
  const testing::RgbdTruth truth = testing::drawn_head(3);
  const RgbdCalibration& c = truth.calibration;
  const Board board = testing::large_board();
  const testing::BoardRenderer colour(board, c.colour, {0.6, 2.5, 2}), amplitude(board, c.depth, {0.5, 3, 4});
  Random random(3);
  testing::BoardPlaces places;
  places.near = 0.5, places.far = 0.46, places.middle = 0.5, places.tilt = 0.2;
  const Eigen::Isometry3d T = places(0, board, c.depth, random);
  const std::string log = (scratch.path() / "board.lcmlog").string();
  LogWriter writer(log);
  for (int i = 0; i < 6; ++i) {
    RgbdFrame frame;
    frame.utime = frame.depth_utime = 1'000'000 * (i + 1);
    cv::cvtColor(colour(c.T_colour_depth * T, random), frame.colour, cv::COLOR_GRAY2BGR);
    if (i == 1) frame.colour.setTo(cv::Scalar::all(90));
    frame.amplitude = amplitude(T, random);
    frame.depth = testing::board_depth(board, truth, T, random);
    writer.write(frame.utime, "CAMERA", encode_message(to_message(encode(frame, 95))));
  }
  writer.close();
  const std::string head = scratch.write("head.yaml", calibration_text(c)).string();
  const auto run =
      with_large_board({"pair", log, "--into", head, "-o", (scratch.path() / "o.yaml").string()});
  EXPECT_THAT(run.out, HasSubstr("6 shots, 1 with the board in both images")) << run.errors;
}

// The order in which docs/CALIBRATION.md has a new user do it.
TEST(CalibrateCommand, TofAndPairGoOnFromWhatCameraFound) {
  const testing::ScratchFolder scratch;
  const testing::RgbdTruth truth = testing::drawn_head(4);
  const RgbdCalibration& c = truth.calibration;
  write_shots(scratch.path() / "shots", truth);
  RgbdCalibration colour_alone;
  colour_alone.sensor = "head";
  colour_alone.colour = colour_alone.depth = c.colour;
  colour_alone.depth_registered = true;
  const std::string head = scratch.write("head.yaml", calibration_text(colour_alone)).string(),
                    shots = (scratch.path() / "shots").string(), tof = (scratch.path() / "tof.yaml").string(),
                    both = (scratch.path() / "both.yaml").string();
  const auto early = with_large_board({"pair", shots, "--into", head, "-o", both});
  EXPECT_EQ(early.exit_code, 1);
  EXPECT_THAT(early.errors, HasSubstr("calibrate tof --into"));

  const auto run = with_large_board({"tof", shots, "--into", head, "-o", tof, "--accept"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.errors;
  EXPECT_THAT(run.out, HasSubstr("calibrate pair finds it"));
  const RgbdCalibration of_tof = load_calibration(tof);
  EXPECT_FALSE(of_tof.depth_registered);
  EXPECT_TRUE(of_tof.colour == c.colour);
  EXPECT_NEAR(of_tof.depth.fx, c.depth.fx, 0.003 * c.depth.fx);

  fs::remove_all(fs::path(shots) / "depth");
  const auto second = with_large_board({"pair", shots, "--into", tof, "-o", both});
  ASSERT_EQ(second.exit_code, 0) << second.out << second.errors;
  EXPECT_THAT(second.out, HasSubstr("note: what ranges err by (depth_error) stays as it was"));
  EXPECT_TRUE(load_calibration(both).depth_error == of_tof.depth_error);
  const RgbdCalibration of_pair = load_calibration(both);
  EXPECT_LT(distance_between(of_pair.T_colour_depth, c.T_colour_depth), 0.003);
  EXPECT_LT(angle_between(of_pair.T_colour_depth, c.T_colour_depth), 0.2 * M_PI / 180);
}

// A driver that registers depth gives amplitude images of colour's size, if any.
TEST(CalibrateCommand, TofRefusesDepthThatIsRegistered) {
  const testing::ScratchFolder scratch;
  RgbdCalibration registered;
  registered.sensor = "head";
  registered.colour = registered.depth = testing::drawn_tof_camera(3);
  registered.depth_registered = true;
  const std::string head = scratch.write("head.yaml", calibration_text(registered)).string();
  fs::create_directories(scratch.path() / "shots/amplitude");
  cv::imwrite((scratch.path() / "shots/amplitude/a.png").string(),
              cv::Mat(144, 176, CV_8UC1, cv::Scalar(90)));
  const auto run = with_large_board({"tof", (scratch.path() / "shots").string(), "--into", head, "-o",
                                     (scratch.path() / "o.yaml").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, HasSubstr("depth_registered: false"));
}

TEST(CalibrateCommand, SaysThatAnInputHasNoAmplitude) {
  const testing::ScratchFolder scratch;
  fs::create_directories(scratch.path() / "images");
  cv::imwrite((scratch.path() / "images/a.png").string(), cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)));
  for (const char* command : {"tof", "pair"})
    EXPECT_THAT(
        calibrate({command, (scratch.path() / "images").string(), "-o", (scratch.path() / "o.yaml").string()})
            .errors,
        HasSubstr("amplitude/"));
}

TEST(CalibrateCommand, SaysWhyNoImageOfALogFitsTheCalibration) {
  const testing::ScratchFolder scratch;
  const std::string log = source_folder() / "logs/kitchen_drive.lcmlog";
  RgbdCalibration other;
  other.sensor = "other";
  other.colour = other.depth = testing::drawn_colour_camera(3);  // the log's depth images are smaller
  other.depth_registered = true;
  const std::string head = scratch.write("head.yaml", calibration_text(other)).string();
  for (const char* command : {"mount", "self"}) {
    const auto run = calibrate({command, log, "--into", head, "-o", (scratch.path() / "o.yaml").string()});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.errors, HasSubstr("by this calibration: "));
    EXPECT_THAT(run.errors, HasSubstr("176x144"));
  }
}

TEST(CalibrateCommand, SelfRefusesAFewKeyframes) {
  const testing::ScratchFolder scratch;
  const std::string log = source_folder() / "logs/kitchen_drive.lcmlog",
                    out = (scratch.path() / "o.yaml").string();
  const auto run = calibrate({"self", log, "-o", out, "--seconds", "4"});
  EXPECT_EQ(run.exit_code, 1) << run.errors;
  EXPECT_THAT(run.out, HasSubstr("missing: only "));
  EXPECT_FALSE(fs::exists(out));
  EXPECT_EQ(calibrate({"self", log, "-o", out, "--seconds", "4", "--accept"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(out));
}

/// A log of two heads on one channel: colour and amplitude images of two sizes each.
void write_two_heads(const std::string& file) {
  LogWriter writer(file);
  for (int i = 0; i < 6; ++i) {
    const int scale = i < 3 ? 1 : 2;
    RgbdFrame frame;
    frame.utime = frame.depth_utime = 1'000'000 * (i + 1);
    frame.colour = cv::Mat(scale * 120, scale * 160, CV_8UC3, cv::Scalar::all(90));
    frame.amplitude = cv::Mat(scale * 60, scale * 80, CV_8UC1, cv::Scalar(90));
    frame.depth = cv::Mat(scale * 60, scale * 80, CV_16UC1, cv::Scalar(1500));
    writer.write(frame.utime, "CAMERA", encode_message(to_message(encode(frame, 95))));
  }
  writer.close();
}

TEST(CalibrateCommand, ImagesOfTwoCamerasInALogAreRefused) {
  const testing::ScratchFolder scratch;
  const std::string log = (scratch.path() / "two.lcmlog").string(),
                    out = (scratch.path() / "o.yaml").string();
  write_two_heads(log);
  EXPECT_THAT(calibrate({"camera", log, "-o", out}).errors,
              HasSubstr("is 320x240, the images before it are 160x120: one camera at a time"));
  EXPECT_THAT(calibrate({"tof", log, "-o", out}).errors,
              HasSubstr("is 160x120, the images before it are 80x60: one camera at a time"));
  EXPECT_THAT(calibrate({"pair", log, "-o", out}).errors, HasSubstr("one camera at a time"));
}

TEST(CalibrateCommand, SelfSaysWhyItUsesNoWheelsAndHowManyImagesItNeeds) {
  const testing::ScratchFolder scratch;
  const std::string log = source_folder() / "logs/kitchen_drive.lcmlog";
  RgbdCalibration unmounted = *calibration_in(log);
  unmounted.has_mount = false;
  const std::string head = scratch.write("head.yaml", calibration_text(unmounted)).string(),
                    out = (scratch.path() / "o.yaml").string();
  const std::vector<std::string> start = {"self", log, "-o", out, "--seconds", "0.5"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), start.begin(), start.end());
    return calibrate(std::move(more));
  };
  EXPECT_THAT(with({"--into", head}).out, HasSubstr("note: wheels are not used"));
  EXPECT_THAT(with({}).out, Not(HasSubstr("wheels are not used")));
  EXPECT_THAT(with({"--rate", "2"}).errors, HasSubstr("--rate 2: "));
  EXPECT_THAT(with({"--rate", "4"}).errors, Not(HasSubstr("--rate 4: ")));
}

TEST(CalibrateCommand, ALogWithoutImagesIsNoDrive) {
  const testing::ScratchFolder scratch;
  const std::string log = scratch.write("notes.lcmlog", "no log").string();
  const auto run = calibrate({"mount", log, "-o", (scratch.path() / "o.yaml").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, HasSubstr("no LCM log"));
}

}  // namespace
}  // namespace lcmslam

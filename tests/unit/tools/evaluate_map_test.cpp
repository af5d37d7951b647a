// lcmslam evaluate --map: what of a map's place and of its surfaces must be known.

#include <fstream>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/evaluate_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MessageLog;

class EvaluateMap : public testing::Evaluate {
 protected:
  const std::string scene_ = source_folder() / "config/scenes/kitchen.yaml";
};

TEST_F(EvaluateMap, AMapWithoutPointsHasNoError) {
  write_log("run.lcmlog");
  std::ofstream(path("map.ply")) << "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n"
                                    "property float y\nproperty float z\nend_header\n";
  ASSERT_EQ(run({path("run.lcmlog"), "--map", path("map.ply"), "--scene", scene_, "--json", path("r.json")}),
            0)
      << output_;
  EXPECT_THAT(output_, AllOf(HasSubstr("0 points"), HasSubstr("median - m, 95 % within - m, mean - m")));
  for (const char* figure : {"median_m", "p95_m", "mean_m", "beyond_share"})
    EXPECT_TRUE(json("r.json").at("map").at(figure).is_null()) << figure;
}

TEST_F(EvaluateMap, AScaledPathPlacesNoMap) {
  write_log("run.lcmlog");
  save_ply(std::filesystem::path(path("map.ply")), ColouredCloud());
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--map", path("map.ply"), "--scene", scene_}, {"--walls", scene_}}) {
    std::vector<std::string> arguments = {path("run.lcmlog"), "--alignment", "sim3"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    EXPECT_EQ(run(arguments), -1);
    EXPECT_THAT(output_, AllOf(HasSubstr(options[0]), HasSubstr("use se3")));
  }
}

// Straight, but for 2 mm to the left; the estimate goes up by 3 mm there: positions alone turn the map by 56
// degrees about the path.
TEST_F(EvaluateMap, AStraightDrivePlacesItsMapByOrientationsToo) {
  Trajectory truth, estimate;
  for (int i = 0; i < 140; ++i) {
    const double x = 0.01 * i, side = std::sin(M_PI * x);
    truth.push_back({1'000'000 + 33'000 * i, planar_pose(2 + x, 2.5 + 0.002 * side, 0)});
    estimate.push_back(truth.back());
    estimate.back().T_world_body.translation().z() = 0.003 * side;
  }
  write_tum(std::filesystem::path(path("truth.txt")), truth);
  write_tum(std::filesystem::path(path("estimate.txt")), estimate);
  ColouredCloud floor;
  for (int i = 0; i < 50; ++i)
    for (const float y : {1.F, 1.8F, 3.2F, 4.F})
      floor.points.emplace_back(2 + 0.02F * static_cast<float>(i), y, 0.F);
  floor.colours.resize(floor.points.size());
  save_ply(std::filesystem::path(path("map.ply")), floor);
  ASSERT_EQ(run({"--truth", path("truth.txt"), path("estimate.txt"), "--map", path("map.ply"), "--scene",
                 scene_, "--json", path("r.json")}),
            0)
      << output_;
  EXPECT_LT(json("r.json").at("map").at("p95_m").get<double>(), 0.02);
  EXPECT_THAT(output_, HasSubstr("leave open how its world is turned"));
}

// Truth and estimate tell the camera's poses, the reference log where it sits on the robot.
TEST_F(EvaluateMap, ReferenceStandsWhereTheTruthsCameraStood) {
  const RgbdCalibration calibration = testing::mounted_camera();
  {
    MessageLog log(path("run.lcmlog"));
    camera_calibration_t c = to_message(calibration);
    c.utime = c.seq = c.sender = 0;
    log.write("CAMERA_CALIBRATION", c);
    RgbdFrame frame;  // a wall 2 m ahead of the camera at the path's first pose
    frame.utime = frame.depth_utime = path_.front().utime;
    frame.colour = cv::Mat(calibration.colour.height, calibration.colour.width, CV_8UC3, cv::Scalar::all(9));
    frame.depth = cv::Mat(calibration.depth.height, calibration.depth.width, CV_16UC1, cv::Scalar(2000));
    frame.depth.row(frame.depth.rows - 1).setTo(1900);  // its skirting: one value alone is no depth
    images_t images = to_message(encode(frame));
    log.write_in_pieces("CAMERA", images);
    images.images[1].data.resize(images.images[1].data.size() / 2);
    images.images[1].size = static_cast<std::int32_t>(images.images[1].data.size());
    log.write("CAMERA", images);
  }
  const Trajectory camera = in_other_frame(path_, calibration.T_robot_camera);
  ColouredCloud cloud;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d p(0.01 * (i % 20), 0.01 * (i / 20), 1.97);
    cloud.points.emplace_back((camera.front().T_world_body * p).cast<float>());
    cloud.colours.emplace_back(1, 2, 3);
  }
  save_ply(std::filesystem::path(path("map.ply")), cloud);
  write_tum(path("truth.txt"), camera);
  write_tum(path("estimate.txt"), testing::moved(camera, planar_pose(1e-7, 0, 0)));
  ASSERT_EQ(run({"--truth", path("truth.txt"), "--truth-frame", "camera", path("estimate.txt"),
                 "--estimate-frame", "camera", "--map", path("map.ply"), "--reference", path("run.lcmlog")}),
            0)
      << output_;
  EXPECT_THAT(output_, AllOf(HasSubstr("median 0.0300 m, 95 % within 0.0300 m"),
                             HasSubstr("run.lcmlog: 1 messages could not be decoded")));
}

// The images were taken by the estimates' clock.
TEST_F(EvaluateMap, ReferenceIsPlacedByTheClockOffsetToo) {
  constexpr Utime late = 400'000;  // us
  const RgbdCalibration calibration = testing::mounted_camera();
  const StampedPose& taken_at = path_[path_.size() / 2];
  const auto write_images = [&](MessageLog& log) {
    camera_calibration_t c = to_message(calibration);
    c.utime = c.seq = c.sender = 0;
    log.write("CAMERA_CALIBRATION", c);
    RgbdFrame frame;  // a wall 2 m ahead
    frame.utime = frame.depth_utime = taken_at.utime + late;
    frame.colour = cv::Mat(calibration.colour.height, calibration.colour.width, CV_8UC3, cv::Scalar::all(9));
    frame.depth = cv::Mat(calibration.depth.height, calibration.depth.width, CV_16UC1, cv::Scalar(2000));
    frame.depth.row(frame.depth.rows - 1).setTo(1900);
    log.write_in_pieces("CAMERA", to_message(encode(frame)));
  };
  {
    MessageLog log(path("images.lcmlog"));
    write_images(log);
  }
  {
    MessageLog log(path("with_truth.lcmlog"));
    write_images(log);
    for (const StampedPose& pose : path_) log.write("GROUND_TRUTH", testing::truth_message(pose, "robot"));
  }
  ColouredCloud cloud;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d p(0.01 * (i % 20), 0.01 * (i / 20), 1.97);
    cloud.points.emplace_back((taken_at.T_world_body * calibration.T_robot_camera * p).cast<float>());
    cloud.colours.emplace_back(1, 2, 3);
  }
  save_ply(std::filesystem::path(path("map.ply")), cloud);
  Trajectory estimate = testing::moved(path_, planar_pose(1e-7, 0, 0));
  for (StampedPose& pose : estimate) pose.utime += late;
  write_tum(path("truth.txt"), path_);
  write_tum(path("estimate.txt"), estimate);
  const auto with = [&](const std::string& truth, const std::string& reference) {
    EXPECT_EQ(run({"--truth", path(truth), "--truth-frame", "robot", path("estimate.txt"), "--estimate-frame",
                   "robot", "--clock-offset", "-0.4", "--map", path("map.ply"), "--reference",
                   path(reference), "--json", path("r.json")}),
              0)
        << output_;
    return json("r.json").at("map").at("median_m").get<double>();
  };
  EXPECT_NEAR(with("truth.txt", "images.lcmlog"), 0.03, 1e-3);
  EXPECT_THAT(output_, HasSubstr("images.lcmlog: its images' stamps are taken -0.4000 s"));
  // Of a log that is the truth's, and nothing was estimated from, the images are on the truth's clock.
  EXPECT_GT(with("with_truth.lcmlog", "with_truth.lcmlog"), 0.05);
  EXPECT_THAT(output_, HasSubstr("with_truth.lcmlog: its images' stamps are taken as they are"));
}

}  // namespace
}  // namespace lcmslam

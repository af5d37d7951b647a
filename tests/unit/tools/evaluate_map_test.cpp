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

}  // namespace
}  // namespace lcmslam

// A recording of somebody else's drivers: images without a word about their camera and poses of unknown
// worth, nothing else. With a calibration file batch maps it better than the poses say; standing still would
// not.

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tests/support/recorded_drive.hpp"
#include "tests/support/source_folder.hpp"
#include "tools/batch/batch_run.hpp"
#include "tools/evaluate/pose_log.hpp"
#include "tools/log/log_edit.hpp"

namespace lcmslam {
namespace {

using testing::RecordedDrive;

pose_t foreign_pose(const odometry_t& odometry) {
  pose_t pose{};
  pose.utime = odometry.utime;
  for (int i = 0; i < 3; ++i) pose.pos[i] = odometry.T_odom_robot.trans[i];
  for (int i = 0; i < 4; ++i) pose.orientation[i] = odometry.T_odom_robot.quat[i];
  return pose;
}

std::string camera_text(const CameraModel& camera) {
  std::ostringstream text;
  text.precision(17);
  text << "{width: " << camera.width << ", height: " << camera.height << ", fx: " << camera.fx
       << ", fy: " << camera.fy << ", cx: " << camera.cx << ", cy: " << camera.cy << ", distortion: [";
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    text << (i > 0 ? ", " : "") << camera.distortion[i];
  return text.str() + "]}";
}

std::string transform_text(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  std::ostringstream text;
  text.precision(17);
  text << "{translation: [" << T.translation().x() << ", " << T.translation().y() << ", "
       << T.translation().z() << "], quaternion: [" << q.w() << ", " << q.x() << ", " << q.y() << ", "
       << q.z() << "]}";
  return text.str();
}

class ForeignRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "lcmslam-foreign-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    write_recording();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// images_t without metadata and pose_t, in order of their time; the calibration goes to a file.
  void write_recording() {
    LogReader reader(own_log("kitchen_drive.lcmlog"));
    LogWriter writer(log());
    testing::TestBus wheels;
    wheels.add<OdometryNode>();
    while (const auto event = reader.next()) {
      const auto* data = event->data.data();
      if (event->channel == "CAMERA") {
        auto images = decode_message<images_t>(data, event->data.size());
        for (image_t& image : images.images) {
          image.metadata.clear();
          image.nmetadata = 0;
        }
        writer.write(event->timestamp, "DRIVER_IMAGES", encode_message(images));
      } else if (event->channel == "ENCODERS") {
        wheels.deliver("ENCODERS", event->data);
        writer.write(event->timestamp, "DRIVER_POSE",
                     encode_message(foreign_pose(wheels.on<odometry_t>("ODOMETRY").back())));
      } else if (event->channel == "CAMERA_CALIBRATION") {
        write_calibration(from_message(decode_message<camera_calibration_t>(data, event->data.size())));
      }
    }
    writer.close();
    odometry_ = wheels.on<odometry_t>("ODOMETRY");
  }

  void write_calibration(const RgbdCalibration& c) const {
    std::ofstream(calibration()) << "sensor: mine\ncolour: " << camera_text(c.colour)
                                 << "\ndepth: " << camera_text(c.depth)
                                 << "\ncolour_depth: " << transform_text(c.T_colour_depth)
                                 << "\nmount: " << transform_text(c.T_robot_camera)
                                 << "\ndepth_noise: {constant: " << c.depth_noise.constant
                                 << ", quadratic: " << c.depth_noise.quadratic
                                 << ", offset: " << c.depth_noise.offset << "}\n";
  }

  /// What a mapper's poses err by, as a share of what the driver's do.
  double share(const PoseLog& maps, const std::string& channel) const {
    RecordedDrive& drive = RecordedDrive::instance();
    std::vector<odometry_t> driven;
    for (const odometry_t& m : odometry_)
      if (m.utime <= odometry_.front().utime + static_cast<Utime>(1e6 * end)) driven.push_back(m);
    return drive.error_of(maps.channel(channel, "batch").trajectory) / drive.error_of(driven);
  }

  std::string log() const { return folder_ / "foreign.lcmlog"; }
  std::string calibration() const { return folder_ / "mine.yaml"; }

  static constexpr double end = RecordedDrive::turned;  // s
  std::filesystem::path folder_;
  std::vector<odometry_t> odometry_;
};

TEST_F(ForeignRecording, ImagesAndPosesAloneAreMapped) {
  BatchOptions options;
  options.config = load_config(source_folder() / "config/replay.yaml", {});
  options.log = log();
  options.folder = folder_ / "maps";
  options.calibration = load_calibration(calibration());
  options.to = end;
  const BatchPlan plan = plan_batch(options);
  EXPECT_THAT(plan.notes, ::testing::Contains(::testing::HasSubstr("external, from DRIVER_POSE")));
  const BatchResult result = run_batch(options, plan);
  EXPECT_THAT(problems_of(result), ::testing::IsEmpty());
  const PoseLog maps = read_pose_log(result.output);
  for (const auto& [channel, largest] : {std::pair("FASTSLAM_POSE", 0.3), std::pair("ICP_POSE", 0.3)}) {
    EXPECT_EQ(maps.channel(channel, "batch").trajectory.size(), static_cast<std::size_t>(result.frames))
        << channel;
    const double found = share(maps, channel);
    std::cout << channel << ": " << found << " of the driver's error\n";
    EXPECT_LT(found, largest) << channel;
  }

  // A log that carries the same calibration gives the same poses.
  calibrate_log(log(), {folder_ / "calibrated.lcmlog", false}, *options.calibration);
  options.log = folder_ / "calibrated.lcmlog";
  options.folder = folder_ / "again";
  options.calibration.reset();
  options.to = 4;
  const PoseLog again = read_pose_log(run_batch(options).output);
  const Trajectory& a = maps.channel("ICP_POSE", "batch").trajectory;
  const Trajectory& b = again.channel("ICP_POSE", "again").trajectory;
  ASSERT_GT(b.size(), 8U);
  for (std::size_t i = 0; i + 1 < b.size(); ++i)  // the last frame's odometry is cut off
    EXPECT_TRUE(b[i].T_world_body.isApprox(a[i].T_world_body, 1e-12)) << i << " of " << b.size();
}

}  // namespace
}  // namespace lcmslam

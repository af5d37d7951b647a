// Whether odometry and camera are stamped by one clock: what `doctor --log` says of a log whose truth is
// known, and whether the key that it names mends it.

#include <gmock/gmock.h>

#include <cmath>

#include <lcmslam/features_t.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tests/unit/tools/log_samples.hpp"
#include "tools/batch/batch_graph.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double seconds = 40, late = 0.08;
constexpr Utime drive_start = 1'000'000'000;

Utime stamp(double t) {
  return drive_start + std::llround(1e6 * t);
}

/// Of a robot that turns in place, to both sides.
double heading(double t) {
  return 0.6 * std::sin(0.7 * t) + 0.2 * std::sin(1.9 * t);
}

struct Thing {
  Eigen::Vector3d place;  // m, world
  Descriptor descriptor;
};

std::vector<Thing> things_around() {
  Random random(7);
  std::vector<Thing> things(250);
  for (Thing& thing : things) {
    const double bearing = random.uniform(-1.8, 1.8), way = random.uniform(2, 5);
    thing.place = {way * std::cos(bearing), way * std::sin(bearing), random.uniform(-0.8, 0.8)};
    for (auto& byte : thing.descriptor) byte = static_cast<std::uint8_t>(random.below(256));
  }
  return things;
}

features_t seen(const std::vector<Thing>& things, double t, Random& random) {
  FeatureFrame frame;
  frame.utime = stamp(t);
  frame.sensor = "camera";
  frame.width = 640, frame.height = 480;
  frame.fx = frame.fy = 525, frame.cx = 319.5, frame.cy = 239.5;
  frame.has_mount = true;
  const Eigen::Isometry3d T_camera_world = (planar_pose(0, 0, heading(t)) * frame.T_robot_camera).inverse();
  for (const Thing& thing : things) {
    const Eigen::Vector3d p = T_camera_world * thing.place;
    const double x = frame.fx * p.x() / p.z() + frame.cx, y = frame.fy * p.y() / p.z() + frame.cy;
    if (p.z() < 0.5 || x < 0 || y < 0 || x > frame.width - 1 || y > frame.height - 1) continue;
    Feature feature;
    feature.x = static_cast<float>(x + random.normal(0, 0.3));
    feature.y = static_cast<float>(y + random.normal(0, 0.3));
    feature.size = 20, feature.laplacian = 1;
    feature.kind = MeasurementKind::point;
    feature.point = (p * (1 + random.normal(0, 0.003))).cast<float>();
    feature.depth_sigma = 0.01F;
    feature.descriptor = thing.descriptor;
    frame.features.push_back(feature);
  }
  return to_message(frame);
}

/// Wheels at both sides, stamped so much later than the camera's clock.
encoders_t counted(double t, double late_by) {
  Encoders encoders;
  encoders.utime = stamp(t + late_by);
  for (const double y : {0.22, -0.22}) {
    Wheel wheel;
    wheel.y = y, wheel.radius = 0.1;
    wheel.angle = -y * heading(t) / wheel.radius;
    encoders.wheels.push_back(wheel);
  }
  return to_message(encoders);
}

/// FEATURES at 10 Hz and ENCODERS at 50 Hz; with a configuration ODOMETRY in the encoders' place, as the
/// process makes it of them.
std::string drive_log(const testing::ScratchFolder& scratch, const std::string& name, double late_by,
                      const ConfigNode* config = nullptr) {
  const std::string file = (scratch.path() / name).string();
  LogWriter log(file);
  const std::vector<Thing> things = things_around();
  Random random(3);
  std::unique_ptr<BatchGraph> graph;
  if (config != nullptr)
    graph = std::make_unique<BatchGraph>(*config, std::vector<std::string>{"odometry"}, 1,
                                         [&](const BatchMessage& m) {
                                           if (m.channel == "ODOMETRY")
                                             log.write(m.utime, m.channel, m.bytes);
                                         });
  for (int i = 0; i <= 50 * seconds; ++i) {
    const double t = 0.02 * i;
    const auto wheels = encode_message(counted(t, late_by));
    if (graph)
      graph->deliver({"ENCODERS", wheels, stamp(t)});
    else
      log.write(stamp(t), "ENCODERS", wheels);
    if (i % 5 == 0) log.write(stamp(t), "FEATURES", encode_message(seen(things, t, random)));
  }
  if (graph) graph->finish();
  log.close();
  return file;
}

testing::CommandRun doctor(const std::string& log) {
  return testing::run_command({"doctor", doctor_command}, {"--log", log});
}

/// What stands behind these words, s; NaN without them.
double number_after(const std::string& words, const std::string& text) {
  const std::size_t at = text.find(words);
  return at == std::string::npos ? std::nan("") : std::strtod(text.c_str() + at + words.size(), nullptr);
}

TEST(DoctorsClock, NamesTheOffsetOfLateWheelsAndTheKeyThatMendsIt) {
  const testing::ScratchFolder scratch;
  const auto found = doctor(drive_log(scratch, "late.lcmlog", late));
  EXPECT_EQ(found.exit_code, 1) << found.out << found.errors;
  EXPECT_THAT(found.out, HasSubstr("ENCODERS is -8"));
  const double key = number_after("set odometry.clock_offset: ", found.out);
  EXPECT_NEAR(key, -late, 0.002) << found.out;

  // Odometry made with that key is on the camera's clock; made without it the doctor still says what to add.
  const auto odometry = [&](const std::string& name, double offset) {
    const ConfigNode config = load_config(source_folder() / "config/replay.yaml",
                                          {"odometry.clock_offset=" + std::to_string(offset)});
    return doctor(drive_log(scratch, name, late, &config));
  };
  const auto unmended = odometry("unmended.lcmlog", 0), mended = odometry("mended.lcmlog", key);
  EXPECT_EQ(unmended.exit_code, 1);
  EXPECT_THAT(unmended.out, HasSubstr("to the setting odometry.clock_offset"));
  EXPECT_NEAR(number_after("; add ", unmended.out), -late, 0.002) << unmended.out;
  EXPECT_EQ(mended.exit_code, 0) << mended.out;
  EXPECT_THAT(mended.out, HasSubstr("ODOMETRY is "));
  EXPECT_THAT(mended.out, Not(HasSubstr("clock_offset")));
}

TEST(DoctorsClock, FindsOneClockGood) {
  const testing::ScratchFolder scratch;
  const auto found = doctor(drive_log(scratch, "sound.lcmlog", 0));
  EXPECT_EQ(found.exit_code, 0) << found.out << found.errors;
  EXPECT_NEAR(number_after("ENCODERS is ", found.out), 0, 2) << found.out;  // ms
  EXPECT_THAT(found.out, Not(HasSubstr("clock_offset")));
}

TEST(DoctorsClock, SaysThatALogHasNoOdometry) {
  const testing::ScratchFolder scratch;
  const std::string file = (scratch.path() / "camera.lcmlog").string();
  LogWriter log(file);
  log.write(drive_start, "CAMERA", testing::camera_message(drive_start, 0));
  log.close();
  const auto found = doctor(file);
  EXPECT_EQ(found.exit_code, 0);
  EXPECT_THAT(found.out, HasSubstr("no ENCODERS, TWIST, POSE_BODY or ODOMETRY"));
}

}  // namespace
}  // namespace lcmslam

// What is planted is found, and nothing is found that is not there: on simulated and on recorded frames.

#include <lcmslam/rgbd/plausibility.hpp>

#include <gmock/gmock.h>

#include <map>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/rgbd/mount_motion.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "tests/support/recordings.hpp"
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/batch/batch_run.hpp"
#include "tools/log/log_plausibility.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A dozen frames of a head.
struct Material {
  RgbdCalibration calibration;
  std::vector<RgbdFrame> frames;
};

constexpr int looked_at = 12;

Material simulated(const std::string& scene, const std::string& head) {
  SimulationSettings settings;
  settings.scene = source_folder().string() + "/config/scenes/" + scene + ".yaml";
  settings.head = head;
  const Simulation simulation(settings);
  Material material{simulation.calibration(), {}};
  for (int i = 0; i < looked_at; ++i)
    material.frames.push_back(
        simulation.render(simulation.start() + (simulation.end() - simulation.start()) * i / looked_at));
  return material;
}

Material recorded(const std::string& folder) {
  const auto source = open_dataset(recording_path(folder));
  Material material{source->calibration(), {}};
  const std::size_t step = source->size() / looked_at + 1;
  for (std::size_t i = 0; i < source->size(); i += step)
    if (const auto frame = source->frame(i)) material.frames.push_back(decode(*frame));
  return material;
}

/// Each is made once.
const Material& material(const std::string& name) {
  static std::map<std::string, Material> made;
  if (made.count(name) == 0) {
    const std::size_t blank = name.find(' ');
    made[name] = blank == std::string::npos ? recorded(name)
                                            : simulated(name.substr(0, blank), name.substr(blank + 1));
  }
  return made.at(name);
}

std::vector<std::string> findings_of(const Material& m) {
  Plausibility check(m.calibration);
  for (const RgbdFrame& frame : m.frames) check.add(frame);
  if (std::getenv("SHOW") != nullptr) {
    const auto e = check.edges().best();
    std::cerr << check.edges().edge_points() << " edges: scale " << e.scale << ", " << e.right << " right, "
              << e.down << " down, gain " << e.gain << ", contrast " << e.contrast << "\n";
    for (const auto& f : check.findings()) std::cerr << "   " << f << "\n";
  }
  return check.findings();
}

class PlausibleMaterial : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string name = GetParam();
    if (name.find(' ') == std::string::npos) LCMSLAM_SKIP_WITHOUT(name);
  }
};

TEST_P(PlausibleMaterial, HasNoFindings) {
  EXPECT_THAT(findings_of(material(GetParam())), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(All, PlausibleMaterial,
                         ::testing::Values("kitchen tof", "kitchen rgbd", "office tof", "office rgbd",
                                           "table tof", "tum_fr1_rpy", "livingroom1", "rgbd_slambook2"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

TEST(PlausibleLogs, OwnOnesHaveNoFindings) {
  for (const char* name : {"kitchen.lcmlog", "kitchen_drive.lcmlog", "office_steered.lcmlog"}) {
    const LogPlausibility found = plausibility_of_log(own_log(name).string());
    EXPECT_GE(found.frames, 3) << name;
    EXPECT_THAT(found.findings, IsEmpty()) << name;
    EXPECT_THAT(format_plausibility(found), HasSubstr("of the pixels have a depth"));
  }
}

void scale_depth(Material& m, double factor) {
  for (RgbdFrame& frame : m.frames) {
    cv::Mat scaled;
    frame.depth.convertTo(scaled, CV_16U, factor);
    scaled.setTo(0, scaled == 65535);  // beyond what fits
    frame.depth = scaled;
  }
}

Eigen::Matrix3d turned(double roll, double pitch, double yaw) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

struct Fault {
  const char* name;
  const char* material;
  void (*plant)(Material&);
  const char* found;
};

class PlantedFault : public ::testing::TestWithParam<Fault> {
 protected:
  void SetUp() override {
    const std::string name = GetParam().material;
    if (name.find(' ') == std::string::npos) LCMSLAM_SKIP_WITHOUT(name);
  }
};

TEST_P(PlantedFault, IsFoundAndNamed) {
  Material m = material(GetParam().material);
  GetParam().plant(m);
  EXPECT_THAT(findings_of(m), Contains(HasSubstr(GetParam().found)));
}

void five_times_too_far(Material& m) {
  scale_depth(m, 5);
}
void five_times_too_near(Material& m) {
  scale_depth(m, 0.2);
}
/// Something close to the camera, a part of the robot: not all of the image is far.
void five_times_too_far_beside_a_near_thing(Material& m) {
  for (RgbdFrame& frame : m.frames) frame.depth.colRange(0, frame.depth.cols / 20).setTo(600);
  scale_depth(m, 5);
}
void swapped(Material& m) {
  std::swap(m.calibration.colour.width, m.calibration.colour.height);
  if (m.calibration.depth_registered) m.calibration.depth = m.calibration.colour;
  m.frames.clear();  // images of another size are refused before anybody looks at them
}
void degrees_for_radians(Material& m) {
  m.calibration.T_robot_camera.linear() = turned(180, 0, 0) * optical_axes().linear();
}
void pitch_in_degrees(Material& m) {
  m.calibration.T_robot_camera.linear() = turned(0, 20, 0) * optical_axes().linear();
}
void millimetres_for_metres(Material& m) {
  m.calibration.T_robot_camera.translation() *= 1000;
}
void from_the_camera_itself(Material& m) {
  m.calibration.T_robot_camera.translation().setZero();
}
void without_optical_axes(Material& m) {
  m.calibration.T_robot_camera.linear() = Eigen::Matrix3d::Identity();
}
/// Depth pixels as those of colour though the camera beside it has taken them: here with nominal values of a
/// Kinect.
void taken_by_the_other_camera(Material& m) {
  for (RgbdFrame& frame : m.frames) {
    cv::Mat depth = cv::Mat::zeros(frame.depth.size(), CV_16U);
    for (int row = 0; row < depth.rows; ++row)
      for (int column = 0; column < depth.cols; ++column) {
        const int z = frame.depth.at<std::uint16_t>(row, column);
        if (z == 0) continue;
        const double right = 585.0 * (column - 320) / 525 + 585 * 25.0 / z;
        const int u = static_cast<int>(std::lround(320 + right));
        const int v = static_cast<int>(std::lround(240 + 585.0 * (row - 240) / 525));
        if (u < 0 || v < 0 || u >= depth.cols || v >= depth.rows) continue;
        std::uint16_t& there = depth.at<std::uint16_t>(v, u);
        if (there == 0 || z < there) there = static_cast<std::uint16_t>(z);
      }
    frame.depth = depth;
  }
}
/// The calibration says that depth has a geometry of its own, but the driver has registered it: a Kinect's.
void registered_already(Material& m) {
  m.calibration.depth_registered = false;
  m.calibration.depth.fx = m.calibration.depth.fy = 585;
  m.calibration.depth.distortion.clear();
  m.calibration.T_colour_depth.translation() = Eigen::Vector3d(-0.025, 0, 0);
}
void called_registered(Material& m) {
  m.calibration.depth_registered = true;
  m.calibration.depth = m.calibration.colour;
}

INSTANTIATE_TEST_SUITE_P(
    All, PlantedFault,
    ::testing::Values(
        Fault{"scale_5_kitchen_tof", "kitchen tof", five_times_too_far, "depth scale wrong by 5"},
        Fault{"scale_5_kitchen_rgbd", "kitchen rgbd", five_times_too_far, "depth scale wrong by 5"},
        Fault{"scale_5_beside_a_near_thing", "kitchen tof", five_times_too_far_beside_a_near_thing,
              "lie outside of the sensor's 0.3 to 7.5 m"},
        Fault{"scale_5_fr1", "tum_fr1_rpy", five_times_too_far, "wrong by 5"},
        Fault{"scale_5_livingroom", "livingroom1", five_times_too_far, "depth scale wrong by 5"},
        Fault{"scale_fifth_kitchen_tof", "kitchen tof", five_times_too_near, "depth scale wrong by 0.2"},
        Fault{"scale_fifth_kitchen_rgbd", "kitchen rgbd", five_times_too_near, "depth scale wrong by 0.2"},
        Fault{"scale_fifth_fr1", "tum_fr1_rpy", five_times_too_near, "wrong by 0.2"},
        Fault{"scale_fifth_livingroom", "livingroom1", five_times_too_near, "depth scale wrong by 0.2"},
        Fault{"swapped_kitchen", "kitchen tof", swapped, "look swapped"},
        Fault{"swapped_fr1", "tum_fr1_rpy", swapped, "look swapped"},
        Fault{"degrees_kitchen_tof", "kitchen tof", degrees_for_radians, "rpy in radians"},
        Fault{"degrees_kitchen_rgbd", "kitchen rgbd", degrees_for_radians, "rpy in radians"},
        Fault{"pitch_in_degrees_kitchen", "kitchen rgbd", pitch_in_degrees, "mount"},
        Fault{"axes_kitchen", "kitchen rgbd", without_optical_axes, "mount"},
        Fault{"no_height_kitchen", "kitchen tof", from_the_camera_itself,
              "the mount says 0.00 m: is the mount's height right"},
        Fault{"millimetres_kitchen", "kitchen tof", millimetres_for_metres, "millimetres"},
        Fault{"other_camera_fr1", "tum_fr1_rpy", taken_by_the_other_camera, "not registered"},
        Fault{"other_camera_livingroom", "livingroom1", taken_by_the_other_camera, "not registered"},
        Fault{"registered_already_fr1", "tum_fr1_rpy", registered_already, "registered already"},
        Fault{"called_registered_kitchen", "kitchen rgbd", called_registered, "not registered"}),
    [](const auto& test) { return std::string(test.param.name); });

/// What surf says in STATUS after a log, with another calibration.
std::string said_by_surf(const std::string& log, void (*change)(RgbdCalibration&)) {
  const testing::ScratchFolder scratch;
  const fs::path changed = scratch.path() / "changed.lcmlog";
  LogReader reader(own_log(log).string());
  LogWriter writer(changed.string());
  while (const auto event = reader.next()) {
    if (event->channel != "CAMERA_CALIBRATION") {
      writer.write(event->timestamp, event->channel, event->data);
      continue;
    }
    const auto before = decode_message<camera_calibration_t>(event->data.data(), event->data.size());
    RgbdCalibration calibration = from_message(before);
    change(calibration);
    camera_calibration_t after = to_message(calibration);
    after.utime = before.utime;
    after.seq = before.seq;
    after.sender = before.sender;
    writer.write(event->timestamp, event->channel, encode_message(after));
  }
  writer.close();
  BatchOptions options;
  options.config = load_config(source_folder() / "config/replay.yaml", {"launch.processes=[surf, odometry]"});
  options.log = changed;
  options.folder = scratch.path() / "out";
  for (const auto& process : run_batch(options).processes)
    if (process.process == "surf") return process.report.detail;
  return "no surf";
}

TEST(PlausibleMotion, OfOwnDrivesFits) {
  for (const char* log : {"kitchen_drive.lcmlog", "office_steered.lcmlog"})
    EXPECT_EQ(said_by_surf(log, [](RgbdCalibration&) {}), "") << log;
}

// Walls stay upright and the floor level: only the motion tells.
TEST(PlausibleMotion, ACameraThatLooksToTheSideIsFound) {
  EXPECT_THAT(said_by_surf("kitchen_drive.lcmlog",
                           [](RgbdCalibration& c) {
                             c.T_robot_camera.linear() = turned(0, 0, M_PI / 2) * c.T_robot_camera.linear();
                           }),
              HasSubstr("it does not fit the motion"));
}

TEST(PlausibleMotion, TurnsAboutAnotherAxisAreFound) {
  const Eigen::Isometry3d right = Eigen::Isometry3d(turned(0, 0.35, 0)) * optical_axes();
  const Eigen::Isometry3d wrong = Eigen::Isometry3d(turned(20, 0, 0)) * optical_axes();
  MountMotion of_right(right), of_wrong(wrong);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Isometry3d robot = planar_pose(0.02, 0, i % 2 == 0 ? 0.1 : -0.1);
    const Eigen::Isometry3d seen = right.inverse() * robot * right;
    of_right.add(seen, robot);
    of_wrong.add(seen, robot);
  }
  EXPECT_EQ(of_right.finding(), "");
  EXPECT_THAT(of_wrong.finding(), HasSubstr("0.00, -0.94, -0.34] of its axes"));
}

TEST(PlausibleMotion, AnotherScaleOfDepthIsFound) {
  for (const double scale : {0.2, 1.0, 5.0}) {
    MountMotion check(optical_axes());
    for (int i = 0; i < 10; ++i) {
      const Eigen::Isometry3d robot = planar_pose(0.05, 0, 0.005);
      Eigen::Isometry3d seen = optical_axes().inverse() * robot * optical_axes();
      seen.translation() *= scale;
      check.add(seen, robot);
    }
    EXPECT_EQ(check.finding().empty(), scale == 1.0) << check.finding();
  }
}

// Beside the robot's middle a camera goes another way than that does: on the inside of a circle a shorter
// one.
TEST(PlausibleMotion, ACircleIsNoMatterOfDepthsScale) {
  const Eigen::Isometry3d mount = Eigen::Translation3d(0, 0.45, 0.5) * optical_axes();
  MountMotion check(mount);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Isometry3d robot = planar_pose(0.075, 0, 0.075);  // of 1 m
    check.add(mount.inverse() * robot * mount, robot);
  }
  EXPECT_EQ(check.finding(), "");
}

}  // namespace
}  // namespace lcmslam

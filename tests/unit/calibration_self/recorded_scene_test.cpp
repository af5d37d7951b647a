// From images to a calibration: a short drive that the simulation renders, begun beside the truth.

#include <lcmslam/calibration/self/head_calibration.hpp>
#include <lcmslam/calibration/self/recorded_scene.hpp>

#include <gmock/gmock.h>
#include <set>
#include <tuple>

#include <lcmslam/calibration/self/aligned_sightings.hpp>
#include <lcmslam/calibration/self/self_report.hpp>
#include <lcmslam/odometry/odometry_clock.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>
#include <lcmslam/simulation/simulation.hpp>

#include "tests/support/dark_frame.hpp"
#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr Utime frame_period = 250'000;  // us

struct Drive {
  RgbdCalibration truth, start;
  std::vector<MotionSample> wheels;
  std::vector<RgbdFrame> frames;
  std::unique_ptr<RecordedScene> recording;
};

/// Some seconds of the kitchen in which the robot turns, rendered once.
const Drive& drive() {
  static const Drive once = [] {
    SimulationSettings settings;
    settings.scene = source_folder() / "config/scenes/kitchen.yaml";
    settings.head = "rgbd";
    const Simulation simulation(settings);
    Drive d;
    RecordedSceneSettings scene_settings;
    scene_settings.landmarks = 1500;
    d.truth = d.start = simulation.calibration();
    d.start.colour.fx *= 1.03, d.start.colour.fy *= 1.03;
    d.start.T_colour_depth.translation() += Eigen::Vector3d(0.012, -0.012, 0.011);
    d.start.T_colour_depth.linear() = so3_exp({0.01, 0.01, -0.01}) * d.start.T_colour_depth.linear();
    d.recording = std::make_unique<RecordedScene>(d.start, scene_settings);
    WheelOdometry wheels;
    Utime next_frame = simulation.start() + 3'000'000;
    for (Utime t = simulation.start(); t < simulation.start() + 13'000'000; t += 20'000)
      if (const auto sample = wheels.update(simulation.encoders(t))) d.wheels.push_back(*sample);
    for (; next_frame < simulation.start() + 12'000'000; next_frame += frame_period)
      d.frames.push_back(simulation.render(next_frame));
    for (const MotionSample& sample : d.wheels) d.recording->add(sample);
    for (const RgbdFrame& frame : d.frames) d.recording->add(frame);
    return d;
  }();
  return once;
}

TEST(RecordedScene, CalibratesAHeadFromAShortDrive) {
  const Drive& d = drive();
  SceneObservations scene = d.recording->observations();
  EXPECT_GT(scene.keyframes.size(), 15U);
  HeadModel model(d.start);
  const BundleSettings settings;
  const BundleResult result = calibrate_head(model, scene, {}, settings);
  const std::string report = report_text(model, result, settings);
  EXPECT_LT(std::abs(model.colour().fx / d.truth.colour.fx - 1), 0.003) << report;
  EXPECT_LT(distance_between(model.T_colour_depth(), d.truth.T_colour_depth), 0.008) << report;
  EXPECT_LT(result.pixel_scale, 0.15) << "textures are found again, not blobs";
  EXPECT_THAT(report, HasSubstr("depth_scale"));
  EXPECT_FALSE(is_observed(result, head::depth_scale, settings)) << report;

  EXPECT_THAT(self_covariance_text(result), HasSubstr("colour_depth.x"));
}

/// Which of the tracks are left, by the sighting that their texture is taken from: that stays as it is.
std::vector<bool> left(const SceneObservations& tracked, const SceneObservations& aligned) {
  std::set<std::tuple<int, double, double>> sightings;
  for (const auto& landmark : aligned.landmarks)
    for (const auto& s : landmark.sightings) sightings.emplace(s.keyframe, s.pixel.x(), s.pixel.y());
  std::vector<bool> result;
  for (const auto& landmark : tracked.landmarks) {
    const LandmarkSighting& s = landmark.sightings[landmark.sightings.size() / 2];
    result.push_back(sightings.count({s.keyframe, s.pixel.x(), s.pixel.y()}) > 0);
  }
  return result;
}

// A head that is a degree off takes other pixels for edges.
TEST(RecordedScene, EdgesAreLeftOutByTheHeadThatIsFound) {
  const Drive& d = drive();
  const SceneObservations tracked = d.recording->observations();
  SceneObservations by_truth = tracked, by_start = tracked, found = tracked;
  align_sightings(by_truth, d.truth);
  align_sightings(by_start, d.start);
  HeadModel model(d.start);
  calibrate_head(model, found, {}, {});
  const auto truly = left(tracked, by_truth);
  const auto differ = [&](const SceneObservations& scene) {
    const auto now = left(tracked, scene);
    int count = 0;
    for (std::size_t i = 0; i < now.size(); ++i) count += now[i] != truly[i] ? 1 : 0;
    return count;
  };
  RecordProperty("by_start", differ(by_start));
  RecordProperty("found", differ(found));
  EXPECT_GT(differ(by_start), 30) << "nothing to tell apart";
  EXPECT_LT(differ(found), differ(by_start) / 2);
}

// The pinned wheels err by so much that a lap leaves 6 ms open; ten do not. What is said covers the error.
TEST(OdometryClock, FindsThatSimulatedWheelsAreLate) {
  for (const std::uint64_t seed : {1U, 3U}) {
    SimulationSettings settings;
    settings.scene = source_folder() / "config/scenes/kitchen.yaml";
    settings.laps = 10;
    settings.seed = seed;
    const Simulation simulation(settings);
    WheelOdometry wheels;
    OdometryClock clock;
    for (Utime t = simulation.start(); t <= simulation.end(); t += 20'000)
      if (auto sample = wheels.update(simulation.encoders(t))) {
        sample->utime += 20'000;
        clock.add_odometry(*sample);
      }
    for (Utime t = simulation.start() + 13'000; t <= simulation.end(); t += 100'000)
      clock.add_camera(t, simulation.T_world_robot(t) * simulation.calibration().T_robot_camera);
    const auto found = clock.estimate();
    ASSERT_TRUE(found.known) << found.reason << ", seed " << seed;
    EXPECT_NEAR(found.offset, -0.020, 0.006) << "seed " << seed;
    EXPECT_LT(std::abs(found.offset + 0.020), 3 * found.sigma) << "seed " << seed;
    RecordProperty("offset_us_" + std::to_string(seed), static_cast<int>(1e6 * found.offset));
    RecordProperty("sigma_us_" + std::to_string(seed), static_cast<int>(1e6 * found.sigma));
  }
}

TEST(RecordedScene, KeepsFewKeyframesSpreadOverALongRecording) {
  const Drive& d = drive();
  RecordedSceneSettings settings;
  settings.keyframes = 5;
  settings.keyframe_translation = settings.keyframe_rotation = 1e-3;  // each image is one
  RecordedScene recording(d.start, settings);
  for (const MotionSample& sample : d.wheels) recording.add(sample);
  std::set<std::size_t> sizes;
  for (const RgbdFrame& frame : d.frames) {
    recording.add(frame);
    sizes.insert(recording.kept_keyframes());
  }
  ASSERT_GT(recording.tracked(), 31) << "they are halved twice";
  EXPECT_EQ(*sizes.rbegin(), 15U);
  EXPECT_LT(recording.kept_keyframes(), 12U);
  const SceneObservations scene = recording.observations();
  ASSERT_EQ(scene.keyframes.size(), 5U);
  const auto& path = recording.path();
  const Utime whole = path.back().utime - path.front().utime;
  for (std::size_t i = 1; i < 5; ++i)
    EXPECT_NEAR(static_cast<double>(scene.keyframes[i].utime - scene.keyframes[i - 1].utime),
                static_cast<double>(whole) / 5, static_cast<double>(whole) / 9)
        << i;
}

// Late by a tenth of a second, or of a log that begins anew.
TEST(RecordedScene, WheelsThatComeLateTakeNothingFromThoseBefore) {
  const Drive& d = drive();
  const SceneObservations in_order = d.recording->observations();
  for (const std::size_t late : {d.wheels.size() - 6, std::size_t{0}}) {
    RecordedScene recording(d.start, RecordedSceneSettings{});
    for (const MotionSample& sample : d.wheels) recording.add(sample);
    recording.add(d.wheels[late]);
    for (const RgbdFrame& frame : d.frames) recording.add(frame);
    const SceneObservations scene = recording.observations();
    ASSERT_EQ(scene.keyframes.size(), in_order.keyframes.size());
    for (std::size_t i = 0; i < scene.keyframes.size(); ++i) {
      EXPECT_EQ(scene.keyframes[i].turn_noise, in_order.keyframes[i].turn_noise) << i;
      EXPECT_TRUE(scene.keyframes[i].twist == in_order.keyframes[i].twist) << i;
    }
    EXPECT_EQ(scene.keyframes[0].turn_noise, RecordedSceneSettings().wheel_turn_noise) << "by wheels";
  }
}

// Two a second, of a camera that moves, sees texture and has depth.
TEST(RecordedScene, SaysThatImagesComeTooSeldomToTellVelocities) {
  const Drive& d = drive();
  RecordedScene recording(d.start, RecordedSceneSettings{});
  for (std::size_t i = 0; i < d.frames.size(); i += 2) recording.add(d.frames[i]);
  ASSERT_GT(recording.kept_keyframes(), 5U);
  try {
    recording.observations();
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("images come 2.0 times a second"));
    EXPECT_THAT(error.what(), Not(HasSubstr("the camera must move")));
  }
}

// The rate that the command allows.
TEST(RecordedScene, FourImagesASecondTellVelocities) {
  const Drive& d = drive();
  RecordedScene recording(d.start, RecordedSceneSettings{});
  for (const RgbdFrame& frame : d.frames) recording.add(frame);
  EXPECT_GT(recording.observations().keyframes.size(), 15U);
  EXPECT_EQ(recording.observations().keyframes[3].turn_noise, RecordedSceneSettings().image_turn_noise);
}

TEST(RecordedScene, WheelsWithoutAMountAreNotUsed) {
  const Drive& d = drive();
  EXPECT_FALSE(d.recording->wheels_lack_mount());
  RgbdCalibration unmounted = d.start;
  unmounted.has_mount = false;
  RecordedScene recording(unmounted, {});
  EXPECT_FALSE(recording.wheels_lack_mount()) << "none came";
  recording.add(d.wheels.front());
  EXPECT_TRUE(recording.wheels_lack_mount());
}

TEST(RecordedScene, SaysWhatARecordingThatStandsStillLacks) {
  RecordedScene recording(drive().truth, {});
  try {
    recording.observations();
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the camera must move"));
  }
}

TEST(RecordedScene, LooksAtNoDepthThatMayBeFolded) {
  const RgbdCalibration head = testing::phase_head();
  RecordedScene bright(head, {}), dark(head, {});
  for (Utime t = 1; t <= 3; ++t) {
    bright.add(testing::wall_of_blobs(head, 100'000 * t, 200));
    dark.add(testing::wall_of_blobs(head, 100'000 * t, 5));
  }
  EXPECT_EQ(bright.tracked(), 3);
  EXPECT_EQ(dark.tracked(), 0);
}

}  // namespace
}  // namespace lcmslam

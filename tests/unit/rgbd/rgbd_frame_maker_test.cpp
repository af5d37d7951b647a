// Two cameras with two clocks on a robot that moves, in exact geometry: everything stands at one moment.

#include <lcmslam/rgbd/rgbd_frame_maker.hpp>

#include <gtest/gtest.h>

#include "tests/support/analytic_scene.hpp"
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

using testing_scene::Scene;

constexpr Utime colour_time = 2'000'000, last_time = 1'900'000;

/// A robot that drives and turns, its cameras, and a corner of walls in the world.
class MovingHead : public testing::Test {
 protected:
  MovingHead() {
    scene_.planes = {{{-1, 0, 0}, -3}, {{0, -1, 0}, -0.8}, {{0, 0, 1}, -0.6}};
    calibration_ = testing_scene::tof_head();
    calibration_.has_mount = true;
    calibration_.T_robot_camera = Eigen::Translation3d(0.1, 0.05, 0.3) *
                                  Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) * optical_axes();
    settings_.depth_filter.parts = {};
    settings_.cloud_points = settings_.keyframe_points = 3000;
  }

  static Eigen::Isometry3d robot(Utime utime) {
    return se3_exp(1e-6 * static_cast<double>(utime - colour_time) * twist(0.5, 0.1, 0, 0, 0, 1.0));
  }
  Eigen::Isometry3d camera(Utime utime) const { return robot(utime) * calibration_.T_robot_camera; }
  static std::optional<Motion> odometry(Utime from, Utime to) {
    Motion motion;
    motion.T_from_to = robot(from).inverse() * robot(to);
    return motion;
  }
  static std::optional<Motion> silence(Utime, Utime) { return std::nullopt; }

  /// `late`: us that depth is measured after colour; its stamp says `stamped`.
  RgbdFrame images(Utime late, Utime stamped) const {
    RgbdFrame frame;
    frame.utime = colour_time;
    frame.depth_utime = colour_time + stamped;
    frame.colour =
        cv::Mat(calibration_.colour.height, calibration_.colour.width, CV_8UC3, cv::Scalar(10, 20, 30));
    frame.depth = testing_scene::render(scene_, calibration_.depth,
                                        camera(colour_time + late) * calibration_.T_colour_depth);
    return frame;
  }
  RgbdFrame images(Utime late) const { return images(late, late); }

  RgbdFrameMaker maker() const {
    RgbdFrameMaker result(settings_);
    result.calibrate(calibration_);
    return result;
  }

  /// m, farthest from a wall, of points in the camera frame at `utime`.
  double off_the_walls(const std::vector<Eigen::Vector3f>& points, Utime utime) const {
    double worst = 0;
    for (const Eigen::Vector3f& p : points) {
      const Eigen::Vector3d world = camera(utime) * p.cast<double>();
      double nearest = 1e9;
      for (const Scene::Plane& plane : scene_.planes)
        nearest = std::min(nearest, std::abs(plane.normal.dot(world) - plane.offset));
      worst = std::max(worst, nearest);
    }
    return worst;
  }

  Scene scene_;
  RgbdCalibration calibration_;
  RgbdFrameMakerSettings settings_;
};

constexpr double millimetre = 0.001;

TEST_F(MovingHead, DepthIsMovedToTheColourImagesTime) {
  RgbdFrameMaker maker = this->maker();
  auto prepared = maker.prepare(images(40'000));
  EXPECT_EQ(prepared.needed, colour_time + 40'000);
  const auto made = maker.make(prepared, odometry, last_time);
  EXPECT_EQ(made.frame.utime, colour_time);
  EXPECT_EQ(made.depth_utime, colour_time + 40'000);
  EXPECT_TRUE(made.T_frame_depth.isApprox(odometry(colour_time, colour_time + 40'000)->T_from_to));
  EXPECT_TRUE(made.frame.T_robot_camera.isApprox(calibration_.T_robot_camera));
  ASSERT_GT(made.frame.cloud.size(), 2000U);
  EXPECT_LT(made.frame.cloud.size(), 6000U);
  EXPECT_LT(off_the_walls(made.frame.cloud.points, colour_time), millimetre);
  EXPECT_GT(off_the_walls(made.frame.cloud.points, colour_time + 40'000), 20 * millimetre);
  // The coloured cloud stands there as well.
  const ColouredCloud coloured = made.frame.colouriser();
  ASSERT_GT(coloured.size(), 1000U);
  EXPECT_LE(coloured.size(), made.frame.cloud.size());
  EXPECT_LT(off_the_walls(coloured.points, colour_time), millimetre);
  EXPECT_EQ(coloured.colours.front(), cv::Vec3b(10, 20, 30));
}

TEST_F(MovingHead, WithoutMotionTheMomentIsDepths) {
  RgbdFrameMaker maker = this->maker();
  FeatureFrame features;
  features.utime = colour_time;
  maker.add(features);
  auto prepared = maker.prepare(images(40'000));
  const auto made = maker.make(prepared, silence, last_time);
  EXPECT_EQ(made.frame.utime, colour_time + 40'000);
  EXPECT_TRUE(made.T_frame_depth.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_LT(off_the_walls(made.frame.cloud.points, colour_time + 40'000), millimetre);
  EXPECT_FALSE(made.frame.features) << "they stand at another moment";
  EXPECT_FALSE(made.added_to_depth);
}

TEST_F(MovingHead, ImagesOfOneMomentNeedNoMotion) {
  RgbdFrameMaker maker = this->maker();
  auto prepared = maker.prepare(images(0));
  const auto made = maker.make(prepared, silence, last_time);
  EXPECT_EQ(made.frame.utime, colour_time);
  EXPECT_LT(off_the_walls(made.frame.cloud.points, colour_time), millimetre);
  EXPECT_EQ(made.added_to_depth, 0);
  auto half_a_millisecond = maker.prepare(images(500));
  EXPECT_EQ(maker.make(half_a_millisecond, odometry, last_time).added_to_depth, -0.0005);
}

// The calibration's offset first; what is left of it is learned from turns.
TEST_F(MovingHead, DepthsClockIsPutRight) {
  calibration_.depth_clock_offset = 0.02;
  RgbdFrameMaker maker = this->maker();
  constexpr Utime late = 35'000;  // in truth; the stamp says 5, the calibration makes it 25
  auto before = maker.prepare(images(late, 5'000));
  EXPECT_EQ(before.needed, colour_time + 25'000);
  const auto wrong = maker.make(before, odometry, last_time);
  EXPECT_EQ(wrong.depth_utime, colour_time + 25'000);
  EXPECT_GT(off_the_walls(wrong.frame.cloud.points, colour_time), 5 * millimetre);
  for (int i = 0; i < 3000; ++i) {
    const double left = 0.01 - maker.depth_clock().offset();  // s
    Motion turn;
    turn.T_from_to = planar_pose(0, 0, 0.1);
    maker.observe(Eigen::Isometry3d::Identity(), planar_pose(0, 0, left * 1.0), turn, 0.1,
                  maker.depth_clock().offset());
  }
  EXPECT_NEAR(maker.depth_clock().offset(), 0.01, 2e-4);
  auto after = maker.prepare(images(late, 5'000));
  EXPECT_NEAR(static_cast<double>(after.needed - colour_time), 35'000, 200);
  const auto right = maker.make(after, odometry, last_time);
  EXPECT_EQ(right.depth_utime, colour_time + 25'000) << "poses are told by the calibration alone";
  EXPECT_LT(off_the_walls(right.frame.cloud.points, colour_time), 1.5 * millimetre);
}

// Odometry that ends between where depth's stamp says that it was taken and where it was: no motion joins the
// images, so depth stays where it is.
TEST_F(MovingHead, DepthIsNotMovedByAWayThatIsHalfKnown) {
  RgbdFrameMaker maker = this->maker();
  for (int i = 0; i < 3000; ++i) {
    Motion turn;
    turn.T_from_to = planar_pose(0, 0, 0.1);
    maker.observe(Eigen::Isometry3d::Identity(), planar_pose(0, 0, -0.005 - maker.depth_clock().offset()),
                  turn, 0.1, maker.depth_clock().offset());
  }
  ASSERT_LT(maker.depth_clock().offset(), -0.004);
  auto prepared = maker.prepare(images(40'000));
  const auto until = [](Utime from, Utime to) {
    return std::max(from, to) < colour_time + 38'000 ? odometry(from, to) : std::nullopt;
  };
  const auto made = maker.make(prepared, until, last_time);
  EXPECT_EQ(made.frame.utime, colour_time + 40'000);
  EXPECT_LT(off_the_walls(made.frame.cloud.points, made.frame.utime), millimetre);
}

// Rows are read within 30 ms around the image's time; pure turning shears the walls by centimetres.
TEST_F(MovingHead, RowsReadOneAfterTheOtherAreStraightened) {
  calibration_ = testing_scene::registered_head();
  calibration_.colour = calibration_.depth = {160, 120, 130, 130, 79.5, 59.5, {}};
  calibration_.has_mount = true;
  calibration_.T_robot_camera = optical_axes();
  constexpr double readout = 0.03;
  RgbdFrame frame = images(0);
  for (int v = 0; v < frame.depth.rows; ++v) {
    const double share = (v + 0.5) / frame.depth.rows - 0.5;
    const auto utime = colour_time + static_cast<Utime>(1e6 * readout * share);
    testing_scene::render(scene_, calibration_.depth, camera(utime)).row(v).copyTo(frame.depth.row(v));
  }
  const auto worst = [&] {
    RgbdFrameMaker maker = this->maker();
    RgbdFrame copy = frame;
    copy.depth = frame.depth.clone();
    auto prepared = maker.prepare(copy);
    const auto made = maker.make(prepared, odometry, last_time);
    return std::max(off_the_walls(made.frame.cloud.points, colour_time),
                    off_the_walls(made.frame.colouriser().points, colour_time));
  };
  EXPECT_GT(worst(), 10 * millimetre);
  calibration_.rolling_shutter = readout;
  EXPECT_LT(worst(), 1.5 * millimetre);
}

TEST_F(MovingHead, FeaturesOfTheImageStandAtItsTime) {
  RgbdFrameMaker maker = this->maker();
  FeatureFrame features;
  features.utime = colour_time;
  features.width = calibration_.colour.width;
  features.height = calibration_.colour.height;
  features.fx = calibration_.colour.fx;
  features.fy = calibration_.colour.fy;
  features.cx = calibration_.colour.cx;
  features.cy = calibration_.colour.cy;
  for (const auto& [x, y] : {std::pair(250.0, 150.0), {320.0, 200.0}, {400.0, 240.0}}) {
    const Eigen::Vector3d ray((x - features.cx) / features.fx, (y - features.cy) / features.fy, 1);
    const Eigen::Isometry3d T = camera(colour_time);
    Feature f;
    f.x = static_cast<float>(x);
    f.y = static_cast<float>(y);
    f.kind = MeasurementKind::point;
    f.point = (1.02 * scene_.hit(T.translation(), T.linear() * ray) * ray).cast<float>();  // a little off
    f.depth_sigma = 0.01f;
    features.features.push_back(f);
  }
  FeatureFrame other = features;
  other.utime = last_time;
  other.features.clear();
  auto prepared = maker.prepare(images(40'000));
  EXPECT_FALSE(maker.make(prepared, odometry, last_time).frame.features) << "none are there";
  maker.add(other);
  maker.add(features);
  const auto made = maker.make(prepared, odometry, last_time);
  ASSERT_TRUE(made.frame.features);
  ASSERT_EQ(made.frame.features->features.size(), 3U);
  std::vector<Eigen::Vector3f> points;
  for (const Feature& f : made.frame.features->features) points.push_back(f.point);
  EXPECT_LT(off_the_walls(points, colour_time), 5 * millimetre);
  // Only the newest few are kept.
  for (int i = 0; i < 32; ++i) maker.add(other);
  EXPECT_FALSE(maker.make(prepared, odometry, last_time).frame.features);
}

TEST_F(MovingHead, IntensitiesComeWithThePointsThatColourSees) {
  settings_.intensities = true;
  RgbdFrameMaker maker = this->maker();
  auto prepared = maker.prepare(images(40'000));
  const auto made = maker.make(prepared, odometry, last_time);
  const ColouredCloud coloured = made.frame.colouriser();
  EXPECT_EQ(made.frame.cloud.points, coloured.points);
  EXPECT_EQ(made.frame.cloud.intensities, intensities_of(coloured));
}

// Clouds tell the camera's noise as it is, and what the depth filter has left of it.
TEST_F(MovingHead, FramesTellWhatTheFilterLeavesOfTheNoise) {
  calibration_.depth_noise = {0.002, 0, 0, 0.001};
  const auto frame_with = [&](const std::vector<std::string>& parts) {
    settings_.depth_filter.parts = parts;
    RgbdFrameMaker maker = this->maker();
    auto prepared = maker.prepare(images(0));
    return maker.make(prepared, odometry, 0).frame;
  };
  const DenseFrame raw = frame_with({}), smooth = frame_with({"bilateral"});
  EXPECT_EQ(raw.noise_left, 1);
  EXPECT_GT(smooth.noise_left, 0.2);
  EXPECT_LT(smooth.noise_left, 0.5);
  ASSERT_EQ(raw.cloud.size(), smooth.cloud.size());
  ASSERT_GT(raw.cloud.size(), 1000U);
  for (std::size_t i = 0; i < raw.cloud.size(); ++i)
    ASSERT_NEAR(smooth.cloud.sigmas[i] / raw.cloud.sigmas[i], 1, 0.01) << "point " << i;
}

// Decoding colour is dear: once, and only for keyframes. Without it points are grey, and none is left out.
TEST_F(MovingHead, ColourIsAskedForLateAndOnce) {
  RgbdFrameMaker maker = this->maker();
  RgbdFrame frame = images(0);
  const cv::Mat colour = std::exchange(frame.colour, cv::Mat());
  int asked = 0;
  auto prepared = maker.prepare(frame, [&] {
    ++asked;
    return colour;
  });
  const auto made = maker.make(prepared, odometry, last_time);
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(made.frame.colouriser().colours.front(), cv::Vec3b(10, 20, 30));
  made.frame.colouriser();
  EXPECT_EQ(asked, 1);
  auto damaged = maker.prepare(frame, [] { return cv::Mat(); });
  const auto grey = maker.make(damaged, odometry, last_time);
  EXPECT_EQ(grey.frame.colouriser().size(), grey.frame.cloud.size());
  EXPECT_EQ(grey.frame.colouriser().colours.front(), cv::Vec3b(128, 128, 128));
}

TEST_F(MovingHead, NothingIsMadeBeforeTheCalibration) {
  RgbdFrameMaker maker(settings_);
  EXPECT_FALSE(maker.calibrated());
  EXPECT_THROW(maker.prepare(images(0)), std::logic_error);
  EXPECT_THROW(maker.calibration(), std::logic_error);
}

}  // namespace
}  // namespace lcmslam

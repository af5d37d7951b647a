#include <lcmslam/simulation/simulation.hpp>

#include <gmock/gmock.h>

#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/scene.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

std::filesystem::path scene_file(const std::string& name) {
  return source_folder() / "config/scenes" / (name + ".yaml");
}

SimulationSettings settings(const std::string& scene, const std::string& base = "differential",
                            const std::string& head = "tof") {
  SimulationSettings result;
  result.scene = scene_file(scene);
  result.base = base;
  result.head = head;
  return result;
}

class EveryScene : public testing::TestWithParam<const char*> {};

TEST_P(EveryScene, PathKeepsThePinnedLimits) {
  for (const char* base : {"differential", "steered"}) {
    const Simulation simulation(settings(GetParam(), base));
    const Utime step = 20'000;
    double driven = 0, fastest = 0, quickest_turn = 0;
    for (Utime t = simulation.start(); t < simulation.end(); t += step) {
      const Eigen::Isometry3d motion =
          simulation.T_world_robot(t).inverse() * simulation.T_world_robot(t + step);
      driven += motion.translation().norm();
      fastest = std::max(fastest, motion.translation().norm() / 0.02);
      quickest_turn = std::max(quickest_turn, rotation_angle(motion) / 0.02);
    }
    const std::string name = GetParam();
    EXPECT_GE(driven, name == "kitchen" ? 12 : name == "table" ? 10 : 40);
    EXPECT_NEAR(driven, simulation.path_length(), 0.02);
    EXPECT_LE(fastest, 0.5) << base;
    EXPECT_GE(fastest, 0.3) << base;
    EXPECT_LE(quickest_turn, M_PI / 3) << base;
  }
}

TEST_P(EveryScene, PathComesBackToPlaces) {
  const Simulation simulation(settings(GetParam()));
  double again = 0;  // m driven within 0.5 m of where the robot was more than 5 m of driving before
  std::vector<Eigen::Vector3d> places;
  for (Utime t = simulation.start(); t <= simulation.end(); t += 100'000) {
    const Eigen::Vector3d here = simulation.T_world_robot(t).translation();
    if (places.empty() || (here - places.back()).norm() > 0.1) {
      for (std::size_t i = 0; i + 50 < places.size(); ++i)
        if ((places[i] - here).norm() < 0.5) {
          again += 0.1;
          break;
        }
      places.push_back(here);
    }
  }
  const std::string name = GetParam();
  EXPECT_GE(again, name == "kitchen" ? 5 : name == "table" ? 0.3 : 5);
  if (name == "table") {
    const Eigen::Isometry3d back =
        simulation.T_world_robot(simulation.start()).inverse() * simulation.T_world_robot(simulation.end());
    EXPECT_LT(back.translation().norm(), 0.02);
    EXPECT_LT(rotation_angle(back), 0.02);
  }
}

// A robot of radius 0.35 m and height 1.4 m: rays around it at many heights stay free.
TEST_P(EveryScene, PathIsFreeOfCollisions) {
  const Scene scene = load_scene(scene_file(GetParam()));
  const RayCaster caster(scene);
  const PlanarPath path(control_points(scene, scene.way_back.empty() ? 1 : 2));
  double clearance = 10;
  for (double t = 0; t < path.duration(); t += 0.2) {
    const Eigen::Vector3f position = path.pose(t).translation().cast<float>();
    for (float height = 0.03f; height < 1.4f; height += 0.06f)
      for (int i = 0; i < 48; ++i) {
        const auto angle = static_cast<float>(2 * M_PI * i / 48);
        const Eigen::Vector3f direction(std::cos(angle), std::sin(angle), 0);
        const double range = caster.cast(position + Eigen::Vector3f(0, 0, height), direction);
        if (range < clearance) clearance = range;
      }
  }
  EXPECT_GT(clearance, 0.35);
}

/// Share of the wall area (partitions included) of plain material with nothing within 0.5 m before it.
double bare_share(const Scene& scene) {
  const RayCaster caster(scene);
  double bare = 0, all = 0;
  for (const SceneTriangle& triangle : scene.triangles) {
    const Eigen::Vector3f normal = triangle.normal[0];
    if (triangle.kind != SurfaceKind::wall || std::abs(normal.z()) > 0.5f) continue;
    const Eigen::Vector3f a = triangle.corner[1] - triangle.corner[0],
                          b = triangle.corner[2] - triangle.corner[0];
    const double area = 0.5 * a.cross(b).norm();
    const int n = 60;
    int free = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const float u = (static_cast<float>(i) + 0.33f) / n, v = (static_cast<float>(j) + 0.33f) / n;
        const Eigen::Vector3f point = triangle.corner[0] + u * a + v * b + 0.001f * normal;
        free += scene.materials[triangle.material].bare && caster.cast(point, normal) > 0.5f;
      }
    bare += area * free / (n * (n + 1) / 2);
    all += area;
  }
  return bare / all;
}

TEST_P(EveryScene, AThirdOfTheWallsIsBare) {
  const double share = bare_share(load_scene(scene_file(GetParam())));
  EXPECT_GE(share, 1.0 / 3);
  EXPECT_LE(share, 0.9);
  RecordProperty("bare_percent", static_cast<int>(100 * share));
}

// Along the path the ToF camera sees surfaces between 0.8 m and 4 m in most of its pixels.
TEST_P(EveryScene, SurfacesStayInView) {
  SimulationSettings s = settings(GetParam());
  const Simulation simulation(s);
  for (Utime t = simulation.start(); t <= simulation.end(); t += 6'000'000) {
    const cv::Mat depth = simulation.render(t).depth;
    cv::Mat near;
    cv::inRange(depth, 800, 4000, near);
    EXPECT_GT(cv::countNonZero(near), 0.4 * static_cast<double>(depth.total())) << "at " << t;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene, testing::Values("kitchen", "table", "office"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(Laps, AreOneDriveThatComesBackToItsStart) {
  SimulationSettings s = settings("kitchen");
  const Simulation once(s);
  s.laps = 3;
  const Simulation drive(s);
  const double lap = (drive.path_length() - once.path_length()) / 2;
  EXPECT_GT(lap, once.path_length() + 1);
  EXPECT_LT(lap, once.path_length() + 4);
  const Utime period = (drive.end() - once.end()) / 2;
  double farthest = 0, fastest = 0, quickest_turn = 0;
  const Utime step = 20'000;
  for (Utime t = drive.start(); t + step < drive.end(); t += step) {
    const Eigen::Isometry3d motion = drive.T_world_robot(t).inverse() * drive.T_world_robot(t + step);
    fastest = std::max(fastest, motion.translation().norm() / 0.02);
    quickest_turn = std::max(quickest_turn, rotation_angle(motion) / 0.02);
    if (t < drive.start() + 10'000'000 || t + period > drive.end() - 10'000'000) continue;
    const Eigen::Isometry3d later = drive.T_world_robot(t + period);
    farthest = std::max(farthest, (later.translation() - drive.T_world_robot(t).translation()).norm());
  }
  EXPECT_LT(farthest, 0.02) << "m between the same moments of two laps";
  EXPECT_LE(fastest, 0.5);
  EXPECT_LE(quickest_turn, M_PI / 3);
  s.scene = scene_file("office");
  EXPECT_THROW((Simulation(s)), std::invalid_argument);
}

bool same(const RgbdFrame& a, const RgbdFrame& b) {
  return a.utime == b.utime && a.depth_utime == b.depth_utime && a.seq == b.seq &&
         cv::norm(a.colour, b.colour, cv::NORM_INF) == 0 && cv::norm(a.depth, b.depth, cv::NORM_INF) == 0 &&
         (a.amplitude.empty() || cv::norm(a.amplitude, b.amplitude, cv::NORM_INF) == 0);
}

// Many laps: all but the first and the last are the same drive, again and again.
class ManyLaps : public testing::Test {
 protected:
  static Simulation drive(int laps, const std::string& base = "differential") {
    SimulationSettings s = settings("kitchen", base);
    s.laps = laps;
    return Simulation(s);
  }
  const Simulation six_ = drive(6);
  const Utime period_ = drive(7).end() - six_.end();
  const Utime moment_ = six_.start() + 60'000'000;  // in the second lap
};

TEST_F(ManyLaps, TakeAWholeNumberOfImagesEachAndAreAlike) {
  EXPECT_EQ(period_ % six_.frame_period(), 0);
  const Simulation three = drive(3);
  EXPECT_NEAR(1e-6 * static_cast<double>(six_.end() - three.end()), 3e-6 * static_cast<double>(period_), 0.3);
  EXPECT_NEAR((six_.path_length() - three.path_length()) / 3, drive(7).path_length() - six_.path_length(),
              1e-9);
  for (Utime t = six_.start() + 40'000'000; t < six_.start() + period_; t += 1'000'000) {
    const Eigen::Isometry3d between = six_.T_world_robot(t).inverse() * six_.T_world_robot(t + 2 * period_);
    EXPECT_LT(between.translation().norm() + rotation_angle(between), 1e-6) << "at " << t;
  }
}

TEST_F(ManyLaps, FollowEachOtherWithoutAJerk) {
  double most = 0;  // m/s that the speed changes in 20 ms
  const Utime step = 20'000;
  for (Utime t = six_.start() + step; t + step < six_.end(); t += step) {
    const Eigen::Isometry3d here = six_.T_world_robot(t);
    const Eigen::Vector3d before = here.inverse() * six_.T_world_robot(t - step).translation(),
                          after = here.inverse() * six_.T_world_robot(t + step).translation();
    most = std::max(most, (before + after).norm() / 0.02);
  }
  EXPECT_LT(most, 0.015);
  const Simulation sideways = drive(6, "mecanum");  // whose swaying does not fit into a lap
  for (Utime t = sideways.start(); t + step < sideways.end(); t += step)
    ASSERT_LT((sideways.T_world_robot(t).inverse() * sideways.T_world_robot(t + step)).translation().norm(),
              0.0101)
        << "at " << t;
}

TEST_F(ManyLaps, WhatIsSeenAgainIsTheSameBytesWhetherItWasKeptOrIsRenderedAnew) {
  const RgbdFrame first = six_.render(moment_), kept = six_.render(moment_ + period_);
  const RgbdFrame anew = drive(6).render(moment_ + period_);
  EXPECT_TRUE(same(kept, anew));
  EXPECT_GT(cv::norm(first.colour, kept.colour, cv::NORM_INF), 0) << "noise of its own";
  EXPECT_GT(cv::norm(first.depth, kept.depth, cv::NORM_INF), 0);
  EXPECT_LT(cv::norm(first.colour, kept.colour, cv::NORM_L1) / static_cast<double>(3 * first.colour.total()),
            3)
      << "grey values, noise and gain";
  EXPECT_EQ(kept.depth_utime - first.depth_utime, period_);
}

class EveryHead : public testing::TestWithParam<const char*> {};

TEST_P(EveryHead, FramesDependOnSeedAndTimeOnly) {
  SimulationSettings s = settings("table", "differential", GetParam());
  const Simulation first(s);
  const Utime t1 = first.start() + 3'000'000, t2 = first.start() + 5'000'000;
  const RgbdFrame a = first.render(t1), b = first.render(t2);
  s.threads = 3;
  const Simulation second(s);
  const RgbdFrame b2 = second.render(t2), a2 = second.render(t1);
  EXPECT_TRUE(same(a, a2));
  EXPECT_TRUE(same(b, b2));
  s.seed = 2;
  const RgbdFrame other = Simulation(s).render(t1);
  EXPECT_GT(cv::norm(a.colour, other.colour, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(a.depth, other.depth, cv::NORM_INF), 0);
}

TEST_P(EveryHead, FramesMatchTheCalibration) {
  const Simulation simulation(settings("kitchen", "differential", GetParam()));
  const RgbdCalibration& calibration = simulation.calibration();
  calibration.check();
  const RgbdFrame frame = simulation.render(simulation.start() + 700'000);
  EXPECT_EQ(frame.sensor, GetParam());
  EXPECT_EQ(frame.seq, static_cast<int>(0.7 * simulation.frame_rate() + 0.5));
  EXPECT_EQ(frame.colour.size(), cv::Size(640, 480));
  EXPECT_EQ(frame.colour.size(), cv::Size(calibration.colour.width, calibration.colour.height));
  EXPECT_EQ(frame.depth.size(), cv::Size(calibration.depth.width, calibration.depth.height));
  EXPECT_EQ(frame.depth.type(), CV_16UC1);
  EXPECT_EQ(frame.amplitude.empty(), frame.sensor == "rgbd");
  EXPECT_NEAR(calibration.T_robot_camera.translation().z(), 1.3, 1e-9);
  const Eigen::Vector3d axis = calibration.T_robot_camera.linear().col(2);
  EXPECT_NEAR(std::asin(-axis.z()), 20 * M_PI / 180, 1e-9);
}

// Rendered depth lies on the scene's exact surfaces once truth and calibration put it there.
TEST_P(EveryHead, DepthLiesOnTheSurfaces) {
  const Simulation simulation(settings("kitchen", "differential", GetParam()));
  const RgbdCalibration& calibration = simulation.calibration();
  const RgbdFrame frame = simulation.render(simulation.start() + 8'000'000);
  const Eigen::Isometry3d T_world_depth =
      simulation.T_world_robot(frame.depth_utime) * calibration.T_robot_camera * calibration.T_colour_depth;
  int inside = 0, all = 0;
  for (int y = 0; y < frame.depth.rows; y += 4)
    for (int x = 0; x < frame.depth.cols; x += 4) {
      const double z = frame.depth.at<std::uint16_t>(y, x) * 0.001;
      if (z == 0) continue;
      const double amplitude = frame.amplitude.empty() ? 1 : frame.amplitude.at<std::uint8_t>(y, x) / 255.0;
      const Eigen::Vector3d point = T_world_depth * (z * calibration.depth.ray(Eigen::Vector2d(x, y)));
      const double quantum = frame.amplitude.empty() ? z * z / (8 * calibration.depth.fx * 0.075) : 0.001;
      inside +=
          simulation.distance_to_surface(point) < 3 * calibration.depth_noise.sigma(z, amplitude) + quantum;
      ++all;
    }
  EXPECT_GT(all, 500);
  EXPECT_GT(inside, 0.98 * all);
}

INSTANTIATE_TEST_SUITE_P(Heads, EveryHead, testing::Values("tof", "rgbd"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(Simulation, DepthStampIsUpTo15MillisecondsOff) {
  std::vector<Utime> offsets;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SimulationSettings s = settings("table");
    s.seed = seed;
    const Simulation simulation(s);
    const RgbdFrame a = simulation.render(2'000'000), b = simulation.render(2'100'000);
    for (const RgbdFrame& frame : {a, b}) EXPECT_LE(std::abs(frame.depth_utime - frame.utime), 15'000);
    EXPECT_LE(std::abs((a.depth_utime - a.utime) - (b.depth_utime - b.utime)), 4'000);
    offsets.push_back(a.depth_utime - a.utime);
  }
  EXPECT_GT(
      *std::max_element(offsets.begin(), offsets.end()) - *std::min_element(offsets.begin(), offsets.end()),
      5000);
}

TEST(Simulation, EncodersAreTheNewestReadingAtATime) {
  const Simulation simulation(settings("table", "steered"));
  EXPECT_EQ(simulation.encoders(simulation.start()).seq, 0);
  EXPECT_EQ(simulation.encoders(simulation.start() + 39'999).seq, 1);
  EXPECT_EQ(simulation.encoders(simulation.start() + 40'000).utime, simulation.start() + 40'000);
  EXPECT_EQ(simulation.encoders(0).seq, 0);
  EXPECT_GE(simulation.encoders(simulation.end()).utime, simulation.end() - 20'000);
}

TEST(Simulation, SecondsAndFrameRateCanBeSet) {
  SimulationSettings s = settings("table");
  s.seconds = 7;
  s.frame_rate = 5;
  const Simulation simulation(s);
  EXPECT_EQ(simulation.end() - simulation.start(), 7'000'000);
  EXPECT_EQ(simulation.frame_rate(), 5);
}

TEST(Simulation, RefusesWrongSettings) {
  EXPECT_THROW(Simulation(settings("table", "hover")), std::invalid_argument);
  EXPECT_THROW(Simulation(settings("table", "steered", "lidar")), std::invalid_argument);
  EXPECT_THROW(Simulation(settings("nowhere")), ConfigError);
  SimulationSettings s = settings("table");
  s.seconds = -1;
  EXPECT_THROW(Simulation{s}, std::invalid_argument);
  s.seconds = 0;
  s.threads = 0;
  EXPECT_THROW(Simulation{s}, std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

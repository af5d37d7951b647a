// Heads of config/heads, and what cameras do besides, against the scene's exact geometry.

#include <gtest/gtest.h>

#include <complex>
#include <fstream>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/simulation/head_piece.hpp>
#include <lcmslam/simulation/head_settings.hpp>
#include <lcmslam/simulation/simulation.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

const std::filesystem::path config_folder = source_folder() / "config";

SimulationSettings with_head(const std::string& head) {
  SimulationSettings result;
  result.scene = config_folder / "scenes/table.yaml";
  result.head = head;
  result.threads = 2;
  return result;
}

// The moment at which the robot turns fastest.
Utime fastest_turn(const Simulation& simulation) {
  Utime best = simulation.start();
  double most = 0;
  for (Utime t = simulation.start(); t + 20'000 < simulation.end(); t += 100'000) {
    const double angle =
        rotation_angle(simulation.T_world_robot(t).inverse() * simulation.T_world_robot(t + 20'000));
    if (angle > most) most = angle, best = t;
  }
  return best;
}

// Median distance of depth points from the scene, with the robot where it truly was, m.
double depth_error(const Simulation& simulation, const RgbdCalibration& c, const RgbdFrame& frame,
                   const Eigen::Isometry3d& T_world_robot) {
  const Eigen::Isometry3d T = T_world_robot * c.T_robot_camera * c.T_colour_depth;
  std::vector<double> errors;
  for (int v = 3; v < frame.depth.rows; v += 29)
    for (int u = 3; u < frame.depth.cols; u += 31)
      if (const auto mm = frame.depth.at<std::uint16_t>(v, u))
        errors.push_back(
            simulation.distance_to_surface(T * Eigen::Vector3d(0.001 * mm * c.depth.ray({u, v}))));
  EXPECT_GT(errors.size(), 25u);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  return errors[errors.size() / 2];
}

double square(double x) {
  return x * x;
}

class ShippedHead : public testing::TestWithParam<const char*> {};

TEST_P(ShippedHead, MeasuresTheSceneWithItsOwnNoise) {
  const Simulation simulation(with_head(GetParam()));
  const RgbdCalibration& c = simulation.calibration();
  EXPECT_EQ(c.sensor, GetParam());
  EXPECT_FALSE(c.depth_registered);
  const Utime t = simulation.start() + 5'000'000;
  const RgbdFrame frame = simulation.render(t);
  EXPECT_EQ(frame.colour.size(), cv::Size(c.colour.width, c.colour.height));
  EXPECT_EQ(frame.depth.size(), cv::Size(c.depth.width, c.depth.height));
  EXPECT_EQ(frame.utime, t);
  const double error = depth_error(simulation, c, frame, simulation.T_world_robot(frame.depth_utime));
  EXPECT_LT(error, 3 * c.depth_noise.sigma(2.5));
  EXPECT_GT(error, 0.0002);
}

INSTANTIATE_TEST_SUITE_P(Heads, ShippedHead,
                         testing::Values("kinect_v1", "realsense_d435", "azure_kinect", "orbbec_astra",
                                         "swissranger"),
                         [](const auto& test) { return std::string(test.param); });

// What a piece truly measures fits what it truly is, and not what it is said to be.
TEST(Heads, PiecesOfAModelAreNotQuiteAsTold) {
  const Simulation described(with_head("tof"));
  EXPECT_EQ(described.true_calibration().colour.fx, described.calibration().colour.fx);
  SimulationSettings settings = with_head("rgbd");
  settings.unit = 2;
  const Simulation piece(settings);
  const RgbdCalibration& told = piece.calibration();
  const RgbdCalibration& built = piece.true_calibration();
  EXPECT_EQ(told.colour.fx, described.calibration().colour.fx);
  EXPECT_NE(built.colour.fx / told.colour.fx, built.depth.fx / told.depth.fx);
  double as_told = 0, as_built = 0;
  for (int i = 1; i <= 12; ++i) {
    const RgbdFrame frame = piece.render(piece.start() + 1'000'000 * i);
    const Utime shot = frame.depth_utime - (frame.utime - piece.start() - 1'000'000 * i);
    as_told += depth_error(piece, told, frame, piece.T_world_robot(frame.depth_utime)) / 12;
    as_built += depth_error(piece, built, frame, piece.T_world_robot(shot)) / 12;
  }
  EXPECT_GT(as_told, 1.2 * as_built);
}

// As large as the mappers are told, and the piece's own.
TEST(Heads, PiecesErrByWhatACarefulCalibrationLeaves) {
  constexpr int pieces = 2000;
  const CameraModel lens = Simulation(with_head("tof")).calibration().colour;
  double focal = 0, clock = 0, place = 0, angle = 0;
  std::complex<double> phase = 0;
  for (std::uint64_t unit = 1; unit <= pieces; ++unit) {
    const HeadPiece piece(unit);
    const CameraModel built = piece.colour(lens);
    EXPECT_NEAR(built.fx / lens.fx, built.fy / lens.fy, 1e-12);
    focal += square(built.fx / lens.fx - 1) / pieces;
    clock += square(1e-6 * static_cast<double>(piece.clock())) / pieces;
    const Vector6d mount = se3_log(piece.mount(Eigen::Isometry3d::Identity()));
    place += mount.head<3>().squaredNorm() / 3 / pieces;
    angle += mount.tail<3>().squaredNorm() / 3 / pieces;
    const TofSensor sensor = piece.sensor({});
    EXPECT_EQ(sensor.wiggle, TofSensor().wiggle);
    phase += std::polar(1.0 / pieces, sensor.wiggle_phase);
  }
  const double within = 4 / std::sqrt(2.0 * pieces);  // four sigmas of a standard deviation
  EXPECT_NEAR(std::sqrt(focal) / 0.001, 1, within);
  EXPECT_NEAR(std::sqrt(clock) / 0.001, 1, within);
  EXPECT_NEAR(std::sqrt(place) / 0.002, 1, within);
  EXPECT_NEAR(std::sqrt(angle) / 0.001, 1, within);
  EXPECT_LT(std::abs(phase), 4 / std::sqrt(pieces)) << "any phase is as likely";
}

TEST(Heads, TheSwissRangersFileMeasuresAsThePinnedHead) {
  const Simulation pinned(with_head("tof")), file(with_head("swissranger"));
  const Utime t = pinned.start() + 3'000'000;
  const RgbdFrame a = pinned.render(t), b = file.render(t);
  EXPECT_EQ(a.depth_utime, b.depth_utime);
  cv::Mat difference;
  cv::absdiff(a.depth, b.depth, difference);
  EXPECT_LT(cv::mean(difference)[0], 5);  // mm; angles are rounded in the file
}

TEST(Heads, TheAzureKinectsCornersAreDark) {
  const RgbdFrame frame = Simulation(with_head("azure_kinect")).render(4'000'000);
  EXPECT_EQ(cv::countNonZero(frame.depth(cv::Rect(0, 0, 60, 60))), 0);
  EXPECT_GT(cv::countNonZero(frame.depth(cv::Rect(160, 144, 320, 288))), 0.3 * 320 * 288);
}

TEST(Heads, UnknownNamesAreRefused) {
  EXPECT_THROW(Simulation(with_head("lidar")), std::invalid_argument);
  EXPECT_THROW(Simulation(with_head("nowhere.yaml")), ConfigError);
  const auto file = std::filesystem::temp_directory_path() / "lcmslam_wrong_head.yaml";
  std::ofstream(file) << "kind: sonar\n";
  EXPECT_THROW(load_head(file), ConfigError);
  std::ofstream(file) << "frame_rat: 3\n";
  EXPECT_THROW(load_head(file), ConfigError);
  std::filesystem::remove(file);
}

std::string written(const std::string& kind, const std::string& sensor) {
  const auto file = std::filesystem::temp_directory_path() / ("lcmslam_head_of_" + kind + ".yaml");
  std::ofstream(file) << "kind: " << kind << "\n" << kind << ": {" << sensor << "}\n";
  return file;
}

TEST(Heads, TellTheNoiseThatTheyHave) {
  for (const std::string sensor : {"disparity_sigma: 0.5", "disparity_sigma: 0.1, offset: 2, quadratic: 0.01",
                                   "disparity_sigma: 0.3, quadratic: 0", "quadratic: 0.004"}) {
    const std::string file = written("triangulation", sensor);
    const RgbdCalibration c = Simulation(with_head(file)).calibration();
    const StructuredLightSensor truth = load_head(file).triangulation;
    for (double z = truth.minimum; z <= truth.maximum; z += 0.2) {
      EXPECT_NEAR(c.depth_noise.sigma(z) / truth.sigma(z, c.depth.fx), 1, 1e-9) << sensor << ", " << z;
      EXPECT_GE(noise_tolerance(truth, c.depth.fx)(z, 0), 3 * truth.sigma(z, c.depth.fx)) << sensor;
    }
    std::filesystem::remove(file);
  }
  const DepthNoise d435 = Simulation(with_head("realsense_d435")).calibration().depth_noise;
  EXPECT_EQ(d435.constant, 0.0005);
  EXPECT_EQ(d435.offset, 0);
}

TEST(Heads, WhatAFileMaySayMakesADrive) {
  for (const auto& [kind, sensor] : {std::pair<std::string, std::string>{"time_of_flight", "wiggle: 0"},
                                     {"triangulation", "constant: 0"},
                                     {"time_of_flight", "unambiguous_range: 65.5"}}) {
    const std::string file = written(kind, sensor);
    const RgbdCalibration told = Simulation(with_head(file)).calibration();
    EXPECT_GE(told.depth_noise.constant, 1e-4) << sensor;
    std::filesystem::remove(file);
  }
  for (const auto& [sensor, key] :
       {std::pair<std::string, std::string>{"unambiguous_range: 100", "unambiguous_range"},
        {"minimum_range: 8", "minimum_range"}}) {
    const std::string file = written("time_of_flight", sensor);
    try {
      load_head(file);
      ADD_FAILURE() << sensor << " is taken";
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find("'" + key + "' must be"), std::string::npos) << error.what();
    }
    std::filesystem::remove(file);
  }
}

// A rolling shutter's first and last row are those of global shutters half a readout earlier and later.
TEST(Faults, ARollingShutterReadsItsRowsOneAfterTheOther) {
  SimulationSettings s = with_head("tof");
  const Simulation still(s);
  s.faults.rolling_shutter = 0.06;
  const Simulation rolling(s);
  const Utime t = fastest_turn(still);
  const cv::Mat seen = rolling.render(t).colour;
  const auto difference = [&](Utime other, int row) {
    cv::Mat rows;
    cv::absdiff(seen.rowRange(row, row + 12), still.render(other).colour.rowRange(row, row + 12), rows);
    const cv::Scalar mean = cv::mean(rows);
    return mean[0] + mean[1] + mean[2];
  };
  EXPECT_LT(difference(t - 30'000, 0), 0.7 * difference(t + 30'000, 0));
  EXPECT_LT(difference(t + 30'000, 468), 0.7 * difference(t - 30'000, 468));
  EXPECT_EQ(rolling.calibration().rolling_shutter, 0);  // colour alone: nobody can be told
  EXPECT_GT(Simulation(with_head("kinect_v1")).calibration().rolling_shutter, 0.02);
}

TEST(Faults, StampsAreWrongAndTheImagesAreNot) {
  SimulationSettings s = with_head("tof");
  const Simulation right(s);
  s.faults.depth_stamp_error = 0.02;
  const Simulation depth_wrong(s);
  s.faults.image_stamp_error = -0.05;
  const Simulation both_wrong(s);
  const Utime t = fastest_turn(right);
  const RgbdFrame a = right.render(t), b = depth_wrong.render(t), c = both_wrong.render(t);
  EXPECT_EQ(b.utime, a.utime);
  EXPECT_EQ(b.depth_utime, a.depth_utime + 20'000);
  EXPECT_EQ(c.utime, a.utime - 50'000);
  EXPECT_EQ(c.depth_utime, a.depth_utime - 30'000);
  EXPECT_EQ(cv::norm(a.depth, c.depth, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(a.colour, c.colour, cv::NORM_INF), 0);

  s.faults = {};
  s.faults.stamp_jitter = 0.003;
  const Simulation jittering(s);
  double sum = 0, most = 0;
  for (int i = 0; i < 16; ++i) {
    const Utime at = right.start() + 100'000 * i;
    const double jitter = 1e-6 * static_cast<double>(jittering.render(at).utime - at);
    sum += jitter * jitter, most = std::max(most, std::abs(jitter));
  }
  EXPECT_LE(most, 0.003001);
  EXPECT_NEAR(std::sqrt(sum / 16), 0.003 / std::sqrt(3), 0.0008);
}

// config/heads has a file for each.
TEST(Faults, FilesOfHeadsHaveThem) {
  const Simulation sound(with_head("swissranger"));
  const Utime t = fastest_turn(sound);
  const RgbdFrame right = sound.render(t);
  const auto unlike = [&](const RgbdFrame& frame) {
    return cv::norm(frame.colour, right.colour, cv::NORM_L1);
  };

  const RgbdFrame late = Simulation(with_head("late_stamps")).render(t);
  EXPECT_EQ(late.utime, right.utime + 20'000);
  EXPECT_EQ(late.depth_utime, right.depth_utime + 20'000);
  EXPECT_EQ(unlike(late), 0);

  const RgbdFrame jittering = Simulation(with_head("jittering_stamps")).render(t);
  EXPECT_NE(jittering.utime, right.utime);
  EXPECT_LE(std::abs(jittering.utime - right.utime), 5'000);
  EXPECT_NE(jittering.utime - right.utime, jittering.depth_utime - right.depth_utime) << "each its own";
  EXPECT_EQ(unlike(jittering), 0);

  const Simulation rolling(with_head("rolling_colour"));
  EXPECT_EQ(rolling.calibration().rolling_shutter, 0) << "nobody is told";
  SimulationSettings asked = with_head("swissranger");
  asked.faults.rolling_shutter = 0.03;
  const RgbdFrame rolled = rolling.render(t);
  EXPECT_GT(unlike(rolled), 0);
  EXPECT_EQ(cv::norm(rolled.colour, Simulation(asked).render(t).colour, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(rolled.depth, right.depth, cv::NORM_INF), 0);

  asked = with_head("swissranger");
  asked.faults.exposure_adaptation = 0.5;
  const RgbdFrame adapted = Simulation(with_head("adapting_exposure")).render(t);
  EXPECT_GT(unlike(adapted), 0);
  EXPECT_EQ(cv::norm(adapted.colour, Simulation(asked).render(t).colour, cv::NORM_INF), 0);
}

TEST(Faults, OfTheSettingsAreBeforeTheFiles) {
  SimulationSettings s = with_head("late_stamps");
  s.faults.image_stamp_error = -0.01;
  const Simulation simulation(s);
  EXPECT_EQ(simulation.render(simulation.start() + 1'000'000).utime, simulation.start() + 990'000);
}

TEST(Faults, TheExposureFollowsTheLight) {
  SimulationSettings s = with_head("tof");
  const Simulation fixed(s);
  s.faults.exposure_adaptation = 0.5;
  const Simulation adapting(s);
  double spread_fixed = 0, spread_adapting = 0;
  for (int i = 0; i < 8; ++i) {
    const Utime t = fixed.start() + 2'000'000 * i;
    const auto grey = [&](const Simulation& simulation) {
      const cv::Scalar mean = cv::mean(simulation.render(t).colour);
      return std::log((mean[0] + mean[1] + mean[2]) / 3 / 110);
    };
    const double of_fixed = grey(fixed), of_adapting = grey(adapting);
    spread_fixed += of_fixed * of_fixed, spread_adapting += of_adapting * of_adapting;
  }
  EXPECT_LT(spread_adapting, 0.5 * spread_fixed);
}

}  // namespace
}  // namespace lcmslam

// Recordings of landmarks: small files of the same form, what is wrong in them, and the real ones.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include <lcmslam/datasets/landmark_recording.hpp>
#include "tests/support/recordings.hpp"
#include "tests/unit/datasets/scratch_folder.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing_files::ScratchFolder;

template <class Function>
std::string error_of(Function function) {
  try {
    function();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

class Mrclam : public testing::Test {
 protected:
  void SetUp() override {
    folder.write("Barcodes.dat", "# Subject # Barcode #\n 1 5\n 2 14\n 6 72\n 7 27\n");
    folder.write("Robot2_Odometry.dat", "# Time v w\n100.0 0.1 0\n100.5 \t 0.1 0.2\n103.0 0 0\n");
    folder.write("Robot2_Measurement.dat",
                 "# Time barcode range bearing\n100.2 72 2.0 0.1\n100.2 27 3.0 -0.4\n"
                 "100.2 5 1.0 0\n102.8 72 2.1 0\n102.8 99 2.1 0\n");
    folder.write("Robot2_Groundtruth.dat", "99.9 1 2 0.5\n101 1.1 2 0.5\n");
    folder.write("Landmark_Groundtruth.dat", "6 3.5 -1 0.001 0.001\n7 1 1 0.001 0.001\n");
  }
  ScratchFolder folder;
  MrclamSensor sensor;
};

TEST_F(Mrclam, IsReadWithIdentitiesInsteadOfBarcodes) {
  const LandmarkRecording r = read_mrclam(folder.path(), 2, sensor);
  ASSERT_EQ(r.twists.size(), 3U);
  EXPECT_EQ(r.twists[1].utime, 100'500'000);
  EXPECT_EQ(r.twists[1].linear, Eigen::Vector3d(0.1, 0, 0));
  EXPECT_EQ(r.twists[1].angular, Eigen::Vector3d(0, 0, 0.2));
  ASSERT_GE(r.frames.size(), 2U);
  const FeatureFrame& first = r.frames.front();
  EXPECT_EQ(first.utime, 100'200'000);
  ASSERT_EQ(first.features.size(), 2U);
  EXPECT_EQ(first.features[0].landmark_id, 6);
  EXPECT_EQ(first.features[0].kind, MeasurementKind::range_bearing);
  EXPECT_FLOAT_EQ(first.features[0].point.x(), 2);
  EXPECT_FLOAT_EQ(first.features[0].point.y(), 0.1F);
  EXPECT_EQ(first.features[1].landmark_id, 7);
  EXPECT_FLOAT_EQ(first.features[1].depth_sigma, static_cast<float>(sensor.range_sigma));
  EXPECT_NEAR(first.pixel_sigma / first.fx, sensor.bearing_sigma, 1e-12);
  ASSERT_EQ(r.truth.size(), 2U);
  EXPECT_NEAR(yaw(r.truth[0].T_world_body), 0.5, 1e-12);
  EXPECT_EQ(r.landmark_truth.at(6), Eigen::Vector2d(3.5, -1));
  EXPECT_TRUE(r.problems.empty());
  EXPECT_THAT(r.notes, Contains(HasSubstr("1 observations of other robots")));
  EXPECT_THAT(r.notes, Contains(HasSubstr("1 observations of barcodes that nobody wears")));
}

TEST_F(Mrclam, FramesWithoutFeaturesFillTheTimeInBetween) {
  sensor.frame_period = 0.5;
  const LandmarkRecording r = read_mrclam(folder.path(), 2, sensor);
  Utime last = r.twists.front().utime;
  std::size_t empty = 0;
  for (std::size_t i = 0; i < r.frames.size(); ++i) {
    EXPECT_EQ(r.frames[i].seq, static_cast<std::int64_t>(i));
    EXPECT_EQ(r.frames[i].sensor, "mrclam robot 2");
    EXPECT_GE(r.frames[i].utime, last);
    EXPECT_LE(r.frames[i].utime - last, 1'000'000);
    last = r.frames[i].utime;
    empty += r.frames[i].features.empty();
  }
  EXPECT_EQ(empty, r.frames.size() - 2);
  EXPECT_GE(empty, 4U);
}

TEST_F(Mrclam, CalibrationOfTheRange) {
  sensor.range_along_axis = true;
  sensor.range_offset = 0.05;
  sensor.range_scale = 1.01;
  const LandmarkRecording r = read_mrclam(folder.path(), 2, sensor);
  EXPECT_NEAR(r.frames.front().features[1].point.x(), (3.0 / std::cos(0.4) - 0.05) / 1.01, 1e-6);
}

TEST_F(Mrclam, BadRowsAreNamedAndLeftOut) {
  folder.write("Robot2_Measurement.dat",
               "100.2 72 2.0 0.1\n100.3 72 two 0.1\n100.4 72 -1 0\n100.5 72 2\nnan 72 2 0\n");
  const LandmarkRecording r = read_mrclam(folder.path(), 2, sensor);
  ASSERT_EQ(r.problems.size(), 4U);
  EXPECT_THAT(r.problems[0], AllOf(HasSubstr("Robot2_Measurement.dat:2"), HasSubstr("two"),
                                   HasSubstr("stamp barcode range bearing")));
  EXPECT_THAT(r.problems[1], AllOf(HasSubstr(":3"), HasSubstr("-1")));
  EXPECT_THAT(r.problems[2], HasSubstr(":4"));
  EXPECT_THAT(r.problems[3], HasSubstr(":5"));
}

TEST_F(Mrclam, FileWithoutAGoodRowIsAnError) {
  folder.write("Robot2_Odometry.dat", "# nothing\n");
  EXPECT_THAT(error_of([&] { read_mrclam(folder.path(), 2, sensor); }), HasSubstr("Robot2_Odometry.dat"));
  EXPECT_THAT(error_of([&] { read_mrclam(folder.path(), 3, sensor); }), HasSubstr("Robot3_Odometry.dat"));
}

TEST_F(Mrclam, RobotThatSeesNoLandmarkIsAnError) {
  folder.write("Robot2_Measurement.dat", "100.2 5 1.0 0\n101.2 5 1.0 0\n102.8 99 2.1 0\n");
  EXPECT_THAT(error_of([&] { read_mrclam(folder.path(), 2, sensor); }),
              AllOf(HasSubstr("Robot2_Measurement.dat: sees no landmark"),
                    HasSubstr("2 observations of other"), HasSubstr("1 of barcodes")));
}

// 40 years in steps of frame_period would not fit into any memory.
TEST_F(Mrclam, DamagedStampIsNotFilledUpTo) {
  sensor.frame_period = 4;
  folder.write("Robot2_Odometry.dat", "0.0 0.1 0\n100.5 0.1 0.2\n90000.0 0 0\n");
  EXPECT_THAT(error_of([&] { read_mrclam(folder.path(), 2, sensor); }),
              AllOf(HasSubstr("Robot2_Odometry.dat"), HasSubstr("from 0.000 to 90000.000 s"),
                    HasSubstr("at most 86400 s")));
}

TEST_F(Mrclam, IsFoundAndTheRobotChosen) {
  EXPECT_EQ(mrclam_robots(folder.path()), std::vector<int>{2});
  EXPECT_TRUE(open_landmark_dataset(folder.path()).has_value());
  EXPECT_THAT(error_of([&] { open_landmark_dataset(folder.path(), 4); }),
              AllOf(HasSubstr("no robot 4"), HasSubstr("There are: 2")));
  folder.write("Robot1_Odometry.dat", "100.0 0.1 0\n");
  folder.write("Robot1_Measurement.dat", "100.2 72 2.0 0.1\n");
  EXPECT_THAT(error_of([&] { open_landmark_dataset(folder.path()); }),
              AllOf(HasSubstr("which robot?"), HasSubstr("1, 2")));
}

TEST(VictoriaPark, PosesLandmarksAndCovariances) {
  ScratchFolder folder;
  folder.write("vp.txt",
               "ODOMETRY 0 1 1 0 0.1 0.0001 0 0 4e-06 0 9e-06\nLANDMARK 1 2 3 -1 0.4 0 0.4\n"
               "ODOMETRY 1 3 2 0 0 0.0001 0 0 4e-06 0 9e-06\nLANDMARK 3 2 1 -1 0.4 0 0.4\n"
               "LANDMARK 3 4 5 2 0.4 0 0.4\n");
  ASSERT_TRUE(is_victoria_park(folder / "vp.txt"));
  const LandmarkRecording r = read_victoria_park(folder / "vp.txt", {1'000'000, 0.5});
  ASSERT_EQ(r.odometry.size(), 3U);
  ASSERT_EQ(r.frames.size(), 3U);
  EXPECT_EQ(r.odometry[2].utime, 2'000'000);
  EXPECT_TRUE(r.odometry[2].T_odom_robot.isApprox(planar_pose(1, 0, 0.1) * planar_pose(2, 0, 0), 1e-12));
  EXPECT_NEAR(r.odometry[1].covariance(0, 0), 1e-4, 1e-12);
  EXPECT_NEAR(r.odometry[1].covariance(1, 1), 4e-6, 1e-12);
  EXPECT_NEAR(r.odometry[1].covariance(5, 5), 9e-6, 1e-12);
  EXPECT_NEAR(r.odometry[2].covariance(1, 1), 8e-6 + 4 * 9e-6, 1e-12);  // the heading's error, 2 m on
  EXPECT_TRUE(r.frames[0].features.empty());
  ASSERT_EQ(r.frames[2].features.size(), 2U);
  EXPECT_EQ(r.frames[1].features[0].landmark_id, r.frames[2].features[0].landmark_id);
  EXPECT_EQ(r.frames[2].features[1].kind, MeasurementKind::planar);
  EXPECT_FLOAT_EQ(r.frames[2].features[1].point.y(), 2);
  EXPECT_NEAR(r.frames[2].features[1].depth_sigma, std::sqrt(0.4), 1e-6);
}

// Any file may be asked about, one of gigabytes too.
TEST(VictoriaPark, IsKnownByWhereItBegins) {
  const ScratchFolder folder;
  const std::string row = "LANDMARK 0 0 1 1 1 0 1\n";
  const auto is_one = [&](const std::string& text) {
    folder.write("any.txt", text);
    return is_victoria_park(folder / "any.txt");
  };
  EXPECT_TRUE(is_one("# a comment\n\n  " + row));
  EXPECT_FALSE(is_one("trees\n" + row));
  EXPECT_FALSE(is_one(std::string(100'000, '#') + "\n" + row));
  EXPECT_FALSE(is_one(""));
}

TEST(VictoriaPark, ErrorsNameFileLineAndValue) {
  ScratchFolder folder;
  const std::string good = "ODOMETRY 0 1 1 0 0.1 0.0001 0 0 4e-06 0 4e-06\n";
  const auto error_with = [&](const std::string& row) {
    folder.write("vp.txt", good + row + "\n");
    return error_of([&] { read_victoria_park(folder / "vp.txt"); });
  };
  EXPECT_EQ(error_with("LANDMARK 1 2 3 -1 0.4 0 0.4"), "");
  EXPECT_THAT(error_with("LANDMARK 1 2 3 x 0.4 0 0.4"), AllOf(HasSubstr("vp.txt:2"), HasSubstr("3 x 0.4")));
  EXPECT_THAT(error_with("LANDMARK 7 2 3 -1 0.4 0 0.4"), HasSubstr("newest pose, 1"));
  EXPECT_THAT(error_with("LANDMARK 1 2 3 -1 0.4 1 0.4"), HasSubstr("positive covariance"));
  EXPECT_THAT(error_with("ODOMETRY 5 6 1 0 0.1 0.0001 0 0 4e-06 0 4e-06"), HasSubstr("pose before, 1"));
  EXPECT_THAT(error_with("ODOMETRY 1 2 1 0 0.1 0.0001 0 0 4e-06"), HasSubstr("6 numbers"));
  EXPECT_THAT(error_with("ODOMETRY 1 2 1 0 0.1 0 0 0 4e-06 0 4e-06"), HasSubstr("positive variances"));
  EXPECT_THAT(error_with("EDGE 1 2"), AllOf(HasSubstr("EDGE 1 2"), HasSubstr("ODOMETRY or LANDMARK")));
}

TEST(LandmarkRecordings, TheRealOnes) {
  LCMSLAM_SKIP_WITHOUT("mrclam_dataset6");
  const fs::path data = recordings_folder();
  const auto mrclam = open_landmark_dataset(data / "mrclam_dataset6", 3);
  ASSERT_TRUE(mrclam);
  EXPECT_TRUE(mrclam->problems.empty());
  EXPECT_EQ(mrclam->landmark_truth.size(), 15U);
  EXPECT_GT(mrclam->twists.size(), 60'000U);
  const auto park = open_landmark_dataset(data / "victoria_park");
  ASSERT_TRUE(park);
  EXPECT_EQ(park->frames.size(), 6969U);
  std::size_t observations = 0;
  for (const FeatureFrame& frame : park->frames) observations += frame.features.size();
  EXPECT_EQ(observations, 3640U);
}

}  // namespace
}  // namespace lcmslam

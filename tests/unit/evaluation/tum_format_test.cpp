#include <lcmslam/evaluation/trajectory.hpp>

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "tests/support/full_disk.hpp"
#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Trajectory parse(const std::string& text) {
  std::istringstream stream(text);
  return read_tum(stream, "poses.txt");
}

std::string error_of(const std::string& text) {
  try {
    parse(text);
  } catch (const TrajectoryError& error) {
    return error.what();
  }
  return "no error";
}

TEST(TumFormat, ReadsCommentsSeparatorsAndMicroseconds) {
  const Trajectory t = parse(
      "# timestamp tx ty tz qx qy qz qw\n\n"
      "1305031102.160407 1.5 -2 3e-1 0 0 0.6 0.8\r\n"
      "  1305031103.160408,1,2,3,\t0,0,0,1\n"
      "1.305031104160409e+09 0 0 0 0 0 0 -1\n");
  ASSERT_EQ(t.size(), 3u);
  EXPECT_EQ(t[0].utime, 1305031102160407);
  EXPECT_EQ(t[1].utime, 1305031103160408);
  EXPECT_EQ(t[2].utime, 1305031104160409);
  EXPECT_EQ(t[0].T_world_body.translation(), Eigen::Vector3d(1.5, -2, 0.3));
  EXPECT_NEAR(yaw(t[0].T_world_body), 2 * std::atan2(0.6, 0.8), 1e-12);
  EXPECT_TRUE(t[2].T_world_body.linear().isIdentity(1e-12));
}

TEST(TumFormat, WritesWhatItReads) {
  Random random(3);
  const Trajectory written = testing::with_noise(testing::curved_path(500), random, 1, 1);
  std::ostringstream text;
  write_tum(text, written);
  const Trajectory read = parse(text.str());
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].utime, written[i].utime);
    EXPECT_LT((read[i].T_world_body.matrix() - written[i].T_world_body.matrix()).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(TumFormat, SortsLinesAndKeepsTheLastOfAStamp) {
  const Trajectory t = parse("3 0 0 3 0 0 0 1\n1 0 0 9 0 0 0 1\n2 0 0 2 0 0 0 1\n1 0 0 1 0 0 0 1\n");
  ASSERT_EQ(t.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(t[i].utime, static_cast<Utime>(i + 1) * 1'000'000);
    EXPECT_EQ(t[i].T_world_body.translation().z(), static_cast<double>(i + 1));
  }
}

TEST(TumFormat, ErrorsNameFileLineAndWhatIsRight) {
  EXPECT_THAT(error_of("# c\n1 2 3\n"),
              AllOf(HasSubstr("poses.txt:2:"), HasSubstr("3 values"), HasSubstr("qx qy qz qw")));
  EXPECT_THAT(error_of("1 0 0 0 0 0 0 1 9\n"), HasSubstr("more than 8"));
  EXPECT_THAT(error_of("1 0 0 zero 0 0 0 1\n"), HasSubstr("'zero' is not a number"));
  EXPECT_THAT(error_of("1 0 0 1.5m 0 0 0 1\n"), HasSubstr("'1.5m' is not a number"));
  EXPECT_THAT(error_of("1 0 0 nan 0 0 0 1\n"), HasSubstr("not finite"));
  EXPECT_THAT(error_of("1 0 0 0 0 0 0 0\n"), HasSubstr("quaternion of norm 0"));
  EXPECT_THAT(error_of("1403636579763555584 0 0 0 0 0 0 1\n"), HasSubstr("expected seconds"));
  EXPECT_THAT(error_of("-1 0 0 0 0 0 0 1\n"), HasSubstr("expected seconds"));
  EXPECT_THAT(error_of("1 0 -1e300 0 0 0 0 1\n"), HasSubstr("expected at most 1e9 m"));
}

TEST(TumFormat, FilesThatCannotBeUsedAreNamed) {
  const std::filesystem::path folder = ::testing::TempDir();
  EXPECT_THROW(read_tum(folder / "no_such_file.txt"), TrajectoryError);
  EXPECT_THROW(read_tum(folder), TrajectoryError);
  EXPECT_THROW(write_tum(folder / "no_such_folder" / "poses.txt", {}), std::runtime_error);
}

TEST(TumFormat, FileRoundTrip) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "lcmslam_tum_round_trip.txt";
  write_tum(file, testing::curved_path(10));
  EXPECT_EQ(read_tum(file).size(), 10u);
  const testing::FullDisk full(100);
  EXPECT_THROW(write_tum(file, testing::curved_path(20)), std::runtime_error);
  EXPECT_EQ(read_tum(file).size(), 10u) << "the old file stays";
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace lcmslam

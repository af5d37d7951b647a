#include <lcmslam/evaluation/pose_text.hpp>

#include <gmock/gmock.h>

#include <unistd.h>
#include <fstream>

#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class PoseTexts : public ::testing::Test {
 protected:
  PoseTexts() { fs::create_directories(folder_); }
  ~PoseTexts() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  static void expect_same(const Trajectory& a, const Trajectory& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].utime, b[i].utime);
      EXPECT_TRUE(a[i].T_world_body.isApprox(b[i].T_world_body, 1e-8)) << i;
    }
  }
  const fs::path folder_ = fs::temp_directory_path() / ("lcmslam-poses-" + std::to_string(getpid()));
};

TEST_F(PoseTexts, TumNamesItsFramesAndComesBack) {
  const Trajectory path = testing::curved_path(20);
  save_tum(folder_ / "a.txt", path, {"map", "robot"});
  const PoseText text = read_pose_text(folder_ / "a.txt");
  EXPECT_EQ(text.format, PoseFormat::tum);
  EXPECT_EQ(text.frame + "/" + text.body, "map/robot");
  EXPECT_EQ(text.assumption, "");
  expect_same(text.trajectory, path);
  expect_same(read_tum(folder_ / "a.txt"), path);
}

TEST_F(PoseTexts, FramesThatAreNotKnownStayUnknown) {
  save_tum(folder_ / "a.txt", testing::curved_path(3), {"", ""});
  EXPECT_EQ(read_pose_text(folder_ / "a.txt").body, "");
  EXPECT_EQ(read_pose_text(write("b.txt", "# ground truth trajectory\n1 0 0 0 0 0 0 1\n")).body, "");
}

TEST_F(PoseTexts, KittiComesBackWithItsTimes) {
  const Trajectory path = testing::curved_path(20);
  save_kitti(folder_ / "a.txt", path);
  const PoseText text = read_pose_text(folder_ / "a.txt");
  EXPECT_EQ(text.format, PoseFormat::kitti);
  EXPECT_EQ(text.assumption, "");
  expect_same(text.trajectory, path);
}

// The first lines of a sequence, by hand: x forward of the second pose is 1, turned by a quarter about y.
TEST_F(PoseTexts, KittiIsAMatrixRowByRow) {
  const fs::path file = write("00.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 0.5 0 1 0 -0.25 -1 0 0 2\n");
  const PoseText assumed = read_pose_text(file);
  EXPECT_THAT(assumed.assumption, HasSubstr("10 Hz"));
  ASSERT_EQ(assumed.trajectory.size(), 2U);
  EXPECT_EQ(assumed.trajectory[1].utime, 100'000);
  EXPECT_TRUE(assumed.trajectory[1].T_world_body.translation().isApprox(Eigen::Vector3d(0.5, -0.25, 2)));
  EXPECT_NEAR((assumed.trajectory[1].T_world_body.linear() * Eigen::Vector3d::UnitX()).z(), -1, 1e-12);
  write("times.txt", "0.000000e+00\n1.036224e-01\n");
  EXPECT_EQ(read_pose_text(file).trajectory[1].utime, 103'622);
  write("times.txt", "0\n");
  EXPECT_THAT(
      [&] { read_pose_text(file); },
      ThrowsMessage<TrajectoryError>(AllOf(HasSubstr("times.txt"), HasSubstr("1 stamps for the 2 poses"))));
}

TEST_F(PoseTexts, EurocHasNanosecondsAndTheRealPartInFront) {
  const PoseText text = read_pose_text(write(
      "data.csv",
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
      "1403636580838555648,4.688319,-1.786938,0.783338,0,1,0,0,-0.027876,0.033207,0.800006\n"
      "1403636580843555648,4.7,-1.8,0.8,1,0,0,0,0,0,0\n"));
  EXPECT_EQ(text.format, PoseFormat::euroc);
  ASSERT_EQ(text.trajectory.size(), 2U);
  EXPECT_EQ(text.trajectory[0].utime, 1'403'636'580'838'555);
  EXPECT_TRUE(
      text.trajectory[0].T_world_body.translation().isApprox(Eigen::Vector3d(4.688319, -1.786938, 0.783338)));
  EXPECT_NEAR(text.trajectory[0].T_world_body.linear()(1, 1), -1, 1e-12) << "half a turn about x";
  EXPECT_TRUE(text.trajectory[1].T_world_body.linear().isIdentity());
}

TEST_F(PoseTexts, WrongLinesAreNamed) {
  const auto error = [&](const std::string& text, const std::string& expected) {
    const fs::path file = write("wrong.txt", text);
    EXPECT_THAT([&] { read_pose_text(file); },
                ThrowsMessage<TrajectoryError>(AllOf(HasSubstr("wrong.txt:"), HasSubstr(expected))));
  };
  error("1 2 3\n", "3 values; expected a line of 8");
  error("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1\n", "11 values; expected 12");
  error("1 0 0 0 0 1 0 0 0 0 2 0\n", "no rotation");
  error("1 0 0 0 0 1 0 0 0 0 x 0\n", "'x' is not a number");
  error("1403636580838555648,1,2,3,0.5,0,0,0\n", "norm 1 (qw qx qy qz, EuRoC)");
  error("1403636580838555648 1 2 3 0 0 0 1\n", "seems to be in ns");
  error("1 0 0 0 0 0 0 2\n", "quaternion of norm 2");
  EXPECT_THROW(read_pose_text(folder_ / "none.txt"), TrajectoryError);
}

}  // namespace
}  // namespace lcmslam

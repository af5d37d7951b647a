#include <lcmslam/map_store/map_export.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <sstream>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include "tests/support/full_disk.hpp"
#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string content(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

void expect_equal(const ColouredCloud& read, const ColouredCloud& written) {
  EXPECT_EQ(read.points, written.points);
  EXPECT_EQ(read.colours, written.colours);
  EXPECT_EQ(read.normals, written.normals);
}

// PCL tells the terminal about each field that a file has not.
TEST(MapExport, ReadingPrintsNothing) {
  const TemporaryFolder folder;
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  for (const bool normals : {false, true}) {
    save_ply(folder / "map.ply", random_cloud(1, 10, normals));
    load_ply(folder / "map.ply");
    save_pcd(folder / "map.pcd", random_cloud(1, 10, normals));
    load_pcd(folder / "map.pcd");
  }
  std::ofstream(folder / "plain.ply")
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nend_header\n1 2 3\n";
  const ColouredCloud plain = load_ply(folder / "plain.ply");
  std::ofstream(folder / "notes.ply") << "what the robot did today\n";
  const std::string error = error_of([&] { load_ply(folder / "notes.ply"); });
  const std::string printed =
      ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(printed, "");
  EXPECT_EQ(plain.points.at(0), Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(plain.colours.at(0), cv::Vec3b(0, 0, 0));
  EXPECT_THAT(error, HasSubstr("notes.ply: no PLY file"));
}

TEST(MapExport, CloudsSurviveTheRoundTrip) {
  const TemporaryFolder folder;
  for (const bool normals : {false, true})
    for (const std::size_t size : {1, 2, 1000}) {
      const ColouredCloud cloud = random_cloud(size, size, normals);
      save_ply(folder / "map.ply", cloud);
      expect_equal(load_ply(folder / "map.ply"), cloud);
      save_pcd(folder / "map.pcd", cloud);
      expect_equal(load_pcd(folder / "map.pcd"), cloud);
    }
  EXPECT_EQ(files_in(folder.path()), 2u) << "no temporary file is left behind";
}

TEST(MapExport, UnknownNormalsAreZeroInPly) {
  const TemporaryFolder folder;
  ColouredCloud cloud = random_cloud(1, 3, true);
  cloud.normals[1].setConstant(NAN);
  save_ply(folder / "map.ply", cloud);
  EXPECT_EQ(load_ply(folder / "map.ply").normals.at(1), Eigen::Vector3f(0, 0, 0));
}

TEST(MapExport, EmptyMapsGiveValidFiles) {
  const TemporaryFolder folder;
  save_ply(folder / "cloud.ply", ColouredCloud());
  save_pcd(folder / "cloud.pcd", ColouredCloud());
  save_ply(folder / "landmarks.ply", std::vector<Landmark>());
  save_pcd(folder / "landmarks.pcd", std::vector<Landmark>());
  for (const char* name : {"cloud.ply", "landmarks.ply"})
    EXPECT_EQ(load_ply(folder / name).size(), 0u) << name;
  for (const char* name : {"cloud.pcd", "landmarks.pcd"})
    EXPECT_EQ(load_pcd(folder / name).size(), 0u) << name;
}

template <class Number>
Number take(const std::string& bytes, std::size_t& at) {
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  at += sizeof number;
  return number;
}

TEST(MapExport, LandmarkPlyHoldsAllProperties) {
  const TemporaryFolder folder;
  std::vector<Landmark> landmarks = {landmark(5, 1, 2, 3), landmark(-7, -4, 5, 6)};
  landmarks[1].covariance << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  landmarks[1].observations = 42;
  save_ply(folder / "l.ply", landmarks);
  const std::string bytes = content(folder / "l.ply");
  EXPECT_THAT(bytes, StartsWith("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(bytes, HasSubstr("element vertex 2\n"));
  EXPECT_THAT(bytes,
              HasSubstr("property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int id\n"
                        "property int observations\nproperty float cov_xx\nproperty float cov_xy\n"));
  std::size_t at = bytes.find("end_header\n") + 11;
  const std::size_t row = 12 + 3 + 4 + 4 + 24;
  ASSERT_EQ(bytes.size(), at + 2 * row);
  at += row;
  for (const float coordinate : {-4.F, 5.F, 6.F}) EXPECT_EQ(take<float>(bytes, at), coordinate);
  for (const int channel : {10, 200, 30}) EXPECT_EQ(take<std::uint8_t>(bytes, at), channel);
  EXPECT_EQ(take<std::int32_t>(bytes, at), -7);
  EXPECT_EQ(take<std::int32_t>(bytes, at), 42);
  for (const float element : {1.F, 2.F, 3.F, 4.F, 5.F, 6.F}) EXPECT_EQ(take<float>(bytes, at), element);

  const ColouredCloud cloud = load_ply(folder / "l.ply");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.colours[0], cv::Vec3b(30, 200, 10));

  landmarks[0].id = std::int64_t{1} << 40;
  save_ply(folder / "wide.ply", landmarks);
  const std::string wide = content(folder / "wide.ply");
  EXPECT_THAT(wide, HasSubstr("property double id\n"));
  at = wide.find("end_header\n") + 11 + 15;
  EXPECT_EQ(take<double>(wide, at), std::ldexp(1.0, 40));
}

TEST(MapExport, LandmarkPcdHoldsPositionColourAndLabel) {
  const TemporaryFolder folder;
  save_pcd(folder / "l.pcd", std::vector<Landmark>{landmark(5, 1, 2, 3)});
  const ColouredCloud cloud = load_pcd(folder / "l.pcd");
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(cloud.colours[0], cv::Vec3b(30, 200, 10));
  EXPECT_THAT(content(folder / "l.pcd"), HasSubstr("FIELDS x y z rgba label"));
}

/// Every way of saving, by the name of its file.
std::vector<std::pair<std::string, std::function<void(const fs::path&)>>> all_saves() {
  const ColouredCloud cloud = random_cloud(1, 20000, true);
  const std::vector<Landmark> landmarks(5000, landmark(1));
  return {{"cloud.ply", [=](const fs::path& file) { save_ply(file, cloud); }},
          {"cloud.pcd", [=](const fs::path& file) { save_pcd(file, cloud); }},
          {"landmarks.ply", [=](const fs::path& file) { save_ply(file, landmarks); }},
          {"landmarks.pcd", [=](const fs::path& file) { save_pcd(file, landmarks); }}};
}

TEST(AtomicFile, ImpossibleTargetsAreNamed) {
  const TemporaryFolder folder;
  for (const auto& [name, save] : all_saves()) {
    const fs::path missing = folder / ("none/" + name);
    EXPECT_THAT(error_of([&] { save(missing); }),
                ::testing::AllOf(HasSubstr(missing.string()), HasSubstr("does not exist")));
    EXPECT_THAT(error_of([&] { save(folder.path()); }), HasSubstr("is a folder"));
    // Not writable, not even for root.
    EXPECT_THAT(error_of([&] { save("/proc/" + name); }), HasSubstr("cannot save /proc/" + name + ": "));
    EXPECT_THAT(error_of([&] { save("/dev/full"); }), HasSubstr("is not a regular file"));
  }
  EXPECT_TRUE(fs::is_character_file("/dev/full")) << "a device must not be replaced";
  EXPECT_EQ(files_in(folder.path()), 0u);
}

TEST(AtomicFile, AFullDiskKeepsTheOldFile) {
  const TemporaryFolder folder;
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  for (const auto& [name, save] : all_saves()) {
    const fs::path file = folder / name;
    std::ofstream(file) << "the old map";
    std::string error;
    {
      const testing::FullDisk full(20000);
      error = error_of([&, &save = save] { save(file); });
    }
    EXPECT_EQ(error, "cannot save " + file.string() + ": File too large");
    EXPECT_EQ(content(file), "the old map");
    EXPECT_NO_THROW(save(file)) << "works once there is room";
    EXPECT_GT(fs::file_size(file), 20000u);
  }
  EXPECT_EQ(files_in(folder.path()), 4u) << "no temporary file is left behind";
  EXPECT_EQ(::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr(), "");
}

// PCL would print of its own.
TEST(MapExport, FilesThatEndTooEarlyAreNamedAndNothingIsPrinted) {
  const TemporaryFolder folder;
  save_ply(folder / "map.ply", random_cloud(1, 1000, true));
  save_pcd(folder / "map.pcd", random_cloud(1, 1000, true));
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  for (const std::string name : {"map.ply", "map.pcd"}) {
    const auto load = [&] { name == "map.ply" ? load_ply(folder / name) : load_pcd(folder / name); };
    for (const std::uintmax_t size : {5000, 250, 40, 4, 0}) {
      fs::resize_file(folder / name, size);
      EXPECT_THAT(error_of(load),
                  ::testing::AllOf(StartsWith("cannot read " + (folder / name).string() + ": "),
                                   HasSubstr(size > 250 ? "cut off"
                                             : size > 0 ? ""
                                                        : "is empty")))
          << size;
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr(), "");
}

TEST(MapExport, UnreadableFilesAreNamed) {
  const TemporaryFolder folder;
  std::ofstream(folder / "bad.ply") << "no ply at all";
  std::ofstream(folder / "bad.pcd") << "no pcd at all";
  EXPECT_THAT(error_of([&] { load_ply(folder / "bad.ply"); }), HasSubstr("bad.ply"));
  EXPECT_THAT(error_of([&] { load_pcd(folder / "bad.pcd"); }), HasSubstr("bad.pcd"));
  EXPECT_THAT(error_of([&] { load_ply(folder / "none.ply"); }), HasSubstr("no such file"));
}

}  // namespace
}  // namespace lcmslam

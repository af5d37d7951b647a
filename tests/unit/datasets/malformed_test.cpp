// Damaged data sets: what is wrong is named, the rest is read.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tests/unit/datasets/scratch_folder.hpp"

namespace lcmslam {
namespace {

using namespace testing_files;
using testing::AllOf;
using testing::HasSubstr;

class Malformed : public testing::Test {
 protected:
  // A healthy TUM folder of six frames.
  void SetUp() override {
    std::string rgb;
    std::string depth;
    for (int i = 0; i < 6; ++i) {
      const std::string n = std::to_string(i);
      rgb += "1." + n + " rgb/" + n + (i < 3 ? ".png\n" : ".jpg\n");
      depth += "1." + n + " depth/" + n + ".png\n";
      folder.write("rgb/" + n + (i < 3 ? ".png" : ".jpg"), colour_image(i));
      folder.write("depth/" + n + ".png", depth_image(5000));
    }
    folder.write("rgb.txt", rgb);
    folder.write("depth.txt", depth);
    folder.write("calibration.yaml", calibration_text());
  }

  // The problem with frame `index`, which must not be given out; the other frames must.
  std::string problem(std::size_t index) {
    const auto source = open_dataset(folder.path());
    EXPECT_EQ(source->size(), 6u);
    for (std::size_t i = 0; i < source->size(); ++i)
      EXPECT_EQ(source->frame(i).has_value(), i != index) << "frame " << i;
    EXPECT_FALSE(source->frame(index).has_value());  // reported once, however often it is asked for
    EXPECT_EQ(source->problems().size(), 1u);
    return source->problems().empty() ? "" : source->problems().front();
  }

  void truncate(const std::string& file, double part) {
    const std::string bytes = folder.read(file);
    folder.write(file, bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
  }

  std::string refusal() {
    try {
      open_dataset(folder.path());
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  ScratchFolder folder;
};

TEST_F(Malformed, TruncatedColourPng) {
  truncate("rgb/1.png", 0.6);
  EXPECT_THAT(problem(1), AllOf(HasSubstr("rgb/1.png"), HasSubstr("damaged")));
}

TEST_F(Malformed, TruncatedColourJpeg) {
  truncate("rgb/4.jpg", 0.95);
  EXPECT_THAT(problem(4), AllOf(HasSubstr("rgb/4.jpg"), HasSubstr("JPEG data")));
}

TEST_F(Malformed, TruncatedDepth) {
  truncate("depth/2.png", 0.5);
  EXPECT_THAT(problem(2), AllOf(HasSubstr("depth/2.png"), HasSubstr("damaged")));
}

TEST_F(Malformed, MissingDepth) {
  std::filesystem::remove(folder / "depth/3.png");
  EXPECT_THAT(problem(3), HasSubstr("depth/3.png: is missing"));
}

TEST_F(Malformed, EmptyColour) {
  folder.write("rgb/0.png", "");
  EXPECT_THAT(problem(0), HasSubstr("rgb/0.png: is empty"));
}

TEST_F(Malformed, TextInsteadOfAnImage) {
  folder.write("depth/5.png", "<html>404 not found</html>");
  EXPECT_THAT(problem(5), AllOf(HasSubstr("depth/5.png"), HasSubstr("not a whole")));
}

TEST_F(Malformed, WrongColourSize) {
  folder.write("rgb/4.jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(9)));
  EXPECT_THAT(problem(4), AllOf(HasSubstr("rgb/4.jpg"), HasSubstr("64x48"), HasSubstr("32x24")));
}

TEST_F(Malformed, WrongDepthSize) {
  folder.write("depth/4.png", cv::Mat(25, 32, CV_16UC1, cv::Scalar::all(9)));
  EXPECT_THAT(problem(4), AllOf(HasSubstr("depth/4.png"), HasSubstr("32x25")));
}

TEST_F(Malformed, DepthOfEightBits) {
  folder.write("depth/4.png", cv::Mat(24, 32, CV_8UC1, cv::Scalar::all(9)));
  EXPECT_THAT(problem(4), AllOf(HasSubstr("depth/4.png"), HasSubstr("16 bits")));
}

// A header that asks for 2 GPixel must not be believed.
TEST_F(Malformed, AbsurdPngHeader) {
  std::string bytes = folder.read("depth/1.png");
  bytes[16] = 0x7f;
  folder.write("depth/1.png", bytes);
  EXPECT_THAT(problem(1), AllOf(HasSubstr("depth/1.png"), HasSubstr("must be 32x24")));
}

TEST_F(Malformed, DamagedFilesNeverCrash) {
  Random random(3);
  int refused = 0;
  for (const char* file : {"rgb/0.png", "rgb/3.jpg", "depth/0.png"}) {
    const std::string good = folder.read(file);
    const std::size_t index = std::string(file) == "rgb/3.jpg" ? 3 : 0;
    for (int trial = 0; trial < 150; ++trial) {
      std::string bytes = good;
      for (int flips = 0; flips < 5; ++flips)
        bytes[random.below(bytes.size())] ^= static_cast<char>(1 << random.below(8));
      folder.write(file, bytes);
      const auto source = open_dataset(folder.path());
      const auto frame = source->frame(index);
      EXPECT_EQ(source->problems().size(), frame ? 0u : 1u);
      refused += frame ? 0 : 1;
    }
    folder.write(file, good);
  }
  EXPECT_GT(refused, 200);
}

TEST_F(Malformed, BadLinesOfTheLists) {
  folder.write("rgb.txt", folder.read("rgb.txt") + "tomorrow rgb/0.png\n2.0\n-1 rgb/1.png\n2.0 a b\n");
  const auto source = open_dataset(folder.path());
  EXPECT_EQ(source->size(), 6u);
  ASSERT_EQ(source->problems().size(), 4u);
  EXPECT_THAT(source->problems()[0], HasSubstr("rgb.txt:7: "));
  EXPECT_THAT(source->problems()[3], HasSubstr("rgb.txt:10: "));
}

TEST_F(Malformed, BadPoses) {
  folder.write("groundtruth.txt",
               "1.0 0 0 0 0 0 0 1\n1.1 0 0 0 0 0 1\n1.2 0 0 nan 0 0 0 1\n1.3 0 0 0 0 0 0 0\n"
               "x 0 0 0 0 0 0 1\n1.5 1 2 3 0 0 0 1 9\n1.6 4 5 6 0 0 0 -1\n");
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->truth().size(), 2u);
  EXPECT_EQ(source->truth()[1].T_world_body.translation().z(), 6);
  ASSERT_EQ(source->problems().size(), 5u);
  for (int line = 2; line <= 6; ++line)
    EXPECT_THAT(source->problems()[static_cast<std::size_t>(line - 2)],
                HasSubstr("groundtruth.txt:" + std::to_string(line) + ": "));
}

TEST_F(Malformed, FoldersThatAreNoDataSet) {
  EXPECT_THROW(open_dataset(folder / "nowhere"), DatasetError);
  EXPECT_THROW(open_dataset(folder / "rgb.txt"), DatasetError);
  folder.write("depth.txt", "# nothing\n");
  EXPECT_THAT(refusal(), HasSubstr("no frame"));
  std::filesystem::remove(folder / "depth.txt");
  EXPECT_THAT(refusal(), AllOf(HasSubstr("no known layout"), HasSubstr("rgb.txt")));
}

TEST_F(Malformed, WrongDescriptions) {
  folder.write("lcmslam.yaml", "format: tun\n");
  EXPECT_THAT(refusal(), AllOf(HasSubstr("lcmslam.yaml"), HasSubstr("format")));
  folder.write("lcmslam.yaml", "depth_scale: 1000\n");
  EXPECT_THAT(refusal(), HasSubstr("format"));
  folder.write("lcmslam.yaml", "format: tum\nframe_rat: 20\n");
  EXPECT_THAT(refusal(), HasSubstr("frame_rat"));
  folder.write("lcmslam.yaml", "format: numbered\ncolour: rgb/%s.png\ndepth: depth/%d.png\n");
  EXPECT_THAT(refusal(), HasSubstr("rgb/%s.png"));
  folder.write("lcmslam.yaml", "format: numbered\ncolour: rgb/%d.png\ndepth: depth/%d.png\nstamps: t.txt\n");
  EXPECT_THAT(refusal(), HasSubstr("t.txt: cannot be opened"));
  folder.write("t.txt", "1\n2\n");
  EXPECT_THAT(refusal(), HasSubstr("has 2 stamps"));
  folder.write("t.txt", "1\n2\n2\n3\n4\n5\n");
  EXPECT_THAT(refusal(), HasSubstr("t.txt:3"));
}

TEST_F(Malformed, PosesOfSevenScenes) {
  const ScratchFolder scenes;
  const char* poses[] = {"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "1 0 0 0\n0 1 0 0\n0 0 1 0\n",
                         "-1.#IND 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
                         "1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n"};
  for (int i = 0; i < 6; ++i) {
    const std::string frame = "frame-00000" + std::to_string(i);
    scenes.write(frame + ".color.png", colour_image(i));
    scenes.write(frame + ".depth.png", depth_image(1000));
    if (i < 5) scenes.write(frame + ".pose.txt", poses[i]);
  }
  scenes.write("calibration.yaml", calibration_text());
  const auto source = open_dataset(scenes.path());
  EXPECT_EQ(source->size(), 6u);  // a frame without pose is still a frame
  EXPECT_EQ(source->truth().size(), 1u);
  ASSERT_EQ(source->problems().size(), 5u);
  EXPECT_THAT(source->problems()[0], HasSubstr("frame-000001.pose.txt"));
  EXPECT_THAT(source->problems()[4], HasSubstr("frame-000005.pose.txt: is missing"));
}

}  // namespace
}  // namespace lcmslam

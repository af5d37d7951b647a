#include <lcmslam/datasets/numbered_files.hpp>

#include <gmock/gmock.h>

#include <lcmslam/datasets/dataset.hpp>
#include "tests/unit/datasets/scratch_folder.hpp"

namespace lcmslam {
namespace {

using namespace testing_files;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(WhyNoFileFits, NamesThePathsTriedAndThePatternThatWouldFit) {
  const ScratchFolder folder;
  folder.write("rgb/00001.png", "x");
  EXPECT_THAT(why_no_file_fits(folder.path(), "rgb/%d.png"),
              AllOf(HasSubstr((folder / "rgb/0.png").string() + " and 1.png are not there"),
                    HasSubstr("but 00001.png is, which rgb/%05d.png would fit")));
  EXPECT_EQ(why_no_file_fits(folder.path(), "rgb/%05d.png"), "");
  folder.write("bare/7.png", "x");
  EXPECT_THAT(why_no_file_fits(folder.path(), "bare/%03d.png"),
              HasSubstr("but 7.png is, which bare/%d.png would fit"));
  folder.write("mixed/a3.txt", "x");
  folder.write("mixed/img_0040.jpg", "x");
  EXPECT_THAT(why_no_file_fits(folder.path(), "mixed/%d.jpg"),
              HasSubstr("which mixed/img_%04d.jpg would fit"));
}

// KITTI's names have ten digits, EuRoC's are nanoseconds since 1970.
TEST(NumberedFiles, ReadsNamesOfManyDigits) {
  const ScratchFolder folder;
  folder.write("kitti/0000000000.png", "x");
  folder.write("kitti/0000000012.png", "x");
  EXPECT_THAT(why_no_file_fits(folder.path(), "kitti/%d.png"), HasSubstr("kitti/%010d.png would fit"));
  ASSERT_TRUE(NumberedFiles::is_pattern("kitti/%010d.png"));
  EXPECT_THAT(NumberedFiles(folder.path(), "kitti/%010d.png").numbers(), ElementsAre(0, 12));
  folder.write("euroc/1403636579763555584.png", "x");
  folder.write("euroc/9999999999999999999.png", "x");  // more than a number holds
  EXPECT_THAT(NumberedFiles(folder.path(), "euroc/%d.png").numbers(), ElementsAre(1403636579763555584));
  EXPECT_FALSE(NumberedFiles::is_pattern("%020d.png"));
  EXPECT_FALSE(NumberedFiles::is_pattern("%099999999999999999999d.png"));
}

TEST(NumberedFiles, NanosecondsAreTimes) {
  const ScratchFolder folder;
  folder.write("calibration.yaml", calibration_text());
  folder.write("lcmslam.yaml",
               "format: numbered\ncolour: rgb/%d.png\ndepth: depth/%d.png\nframe_rate: 1e9\n");
  for (const char* name : {"1403636579763555584.png", "1403636579813555456.png"}) {
    folder.write(std::string("rgb/") + name, colour_image(1));
    folder.write(std::string("depth/") + name, depth_image(1000));
  }
  const auto source = open_dataset(folder.path(), {});
  ASSERT_EQ(source->size(), 2U);
  EXPECT_EQ(source->entry(1).utime - source->entry(0).utime, 50'000);
}

TEST(WhyNoFileFits, NamesAFolderThatIsMissing) {
  const ScratchFolder folder;
  folder.write("color/0.png", "x");
  EXPECT_THAT(why_no_file_fits(folder.path(), "rgb/%d.png"),
              AllOf(HasSubstr((folder / "rgb").string() + " is no folder"), HasSubstr("holds color")));
}

TEST(WhyNoFileFits, IsSaidWhenAFolderIsOpened) {
  const ScratchFolder folder;
  folder.write("rgb/00001.png", colour_image(1));
  folder.write("depth/00001.png", depth_image(1000));
  folder.write("calibration.yaml", calibration_text());
  const std::string layout = "format: numbered\ncolour: rgb/%05d.png\ndepth: depth/%d.png\n";
  const auto error_of = [&](const DatasetOptions& options) -> std::string {
    try {
      open_dataset(folder.path(), options);
    } catch (const DatasetError& error) {
      return error.what();
    }
    return "";
  };
  const auto names_the_cure = AllOf(HasSubstr("no file fits depth/%d.png"), HasSubstr("depth/0.png"),
                                    HasSubstr("depth/%05d.png would fit"));
  folder.write("lcmslam.yaml", layout);
  EXPECT_THAT(error_of({}), AllOf(HasSubstr("lcmslam.yaml"), names_the_cure));
  std::filesystem::rename(folder / "lcmslam.yaml", folder / "mine.yaml");
  DatasetOptions options;
  options.description = folder / "mine.yaml";
  EXPECT_THAT(error_of(options), AllOf(HasSubstr("mine.yaml"), names_the_cure));
  folder.write("mine.yaml", "format: numbered\ncolour: rgb/%05d.png\ndepth: depth/%05d.png\n");
  EXPECT_EQ(open_dataset(folder.path(), options)->size(), 1U);
}

}  // namespace
}  // namespace lcmslam

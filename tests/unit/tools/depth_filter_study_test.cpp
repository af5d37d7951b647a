#include "tools/study/depth_filter_study.hpp"
#include "tests/support/source_folder.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

DepthFilterStudySettings small() {
  DepthFilterStudySettings settings;
  settings.scenes = {source_folder() / "config/scenes/table.yaml"};
  settings.sizes = {{176, 144}};
  settings.images = 3;
  settings.seed = 4;
  settings.curve = {1, 3};
  return settings;
}

// The bar of the whole study, on a small part of it.
TEST(DepthFilterStudy, MixedPixelsGoAndGoodPointsStay) {
  auto methods = depth_filter_methods();
  methods.push_back({"nothing", [](const RgbdCalibration&) { return [](cv::Mat&, const cv::Mat&) {}; }});
  methods.push_back({"everything", [](const RgbdCalibration&) {
                       return [](cv::Mat& depth, const cv::Mat&) { depth.setTo(0); };
                     }});
  const DepthFilterStudyResult result = study_depth_filter(methods, small());
  ASSERT_EQ(result.scores.size(), 2 * methods.size());
  for (const DepthFilterScore& s : result.scores) {
    SCOPED_TRACE(s.head + " " + s.method);
    EXPECT_GT(s.good, 50000);
    if (s.head == "tof") {
      EXPECT_GT(s.mixed, 500);
    }
    if (s.method == "nothing") {
      EXPECT_EQ(s.mixed_removed + s.good_removed, 0);
    } else if (s.method == "everything") {
      EXPECT_EQ(s.mixed_removed, s.mixed);
      EXPECT_EQ(s.lost_share(), 1);
    } else if (s.method == "depth filter") {
      EXPECT_LE(s.lost_share(), 0.05);
      if (s.head == "tof") {
        EXPECT_GE(s.removed_share(), 0.95);
      }
    }
  }
  ASSERT_EQ(result.curve.size(), 2u);
  EXPECT_GT(result.curve[0].removed_share, result.curve[1].removed_share);
  EXPECT_GT(result.curve[0].lost_share, result.curve[1].lost_share);
  EXPECT_THAT(depth_filter_table(result), HasSubstr("tof 176x144 table"));
  EXPECT_EQ(depth_filter_json(result, small()).at("scores").size(), result.scores.size());
}

TEST(DepthFilterStudy, RefusesWhatMakesNoSense) {
  DepthFilterStudySettings settings = small();
  settings.scenes.clear();
  EXPECT_THROW(study_depth_filter(depth_filter_methods(), settings), std::invalid_argument);
  settings = small();
  settings.images = 0;
  EXPECT_THROW(study_depth_filter(depth_filter_methods(), settings), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

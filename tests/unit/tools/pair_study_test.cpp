#include "tools/study/pair_study.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "procs/camera/camera_log.hpp"
#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

const std::string kitchen = source_folder() / "logs/kitchen.lcmlog";

PairStudySettings small() {
  PairStudySettings settings;
  settings.apart = {5};
  settings.starts = 2;
  return settings;
}

TEST(PairStudy, CountsWhatIsRight) {
  auto methods = pair_methods();
  methods.push_back({"far off", [](const PairView&, const PairView&) {
                       return std::optional<Eigen::Isometry3d>(Eigen::Translation3d(5, 0, 0) *
                                                               Eigen::Isometry3d::Identity());
                     }});
  methods.push_back({"gives up", [](const PairView&, const PairView&) { return std::nullopt; }});
  const auto source = open_log(kitchen);
  const PairStudyResult result = study_pairs(*source, methods, small());
  ASSERT_EQ(result.scores.size(), methods.size());
  EXPECT_EQ(result.little_overlap + result.unreadable, 0);
  for (const PairScore& score : result.scores) {
    EXPECT_EQ(score.pairs, 2) << score.method;
    const bool bad = score.method == "far off" || score.method == "gives up";
    EXPECT_EQ(score.right, bad ? 0 : 2) << score.method;  // half a second apart: easy
    EXPECT_EQ(score.solved, score.method == "gives up" ? 0 : 2) << score.method;
    if (bad) continue;
    EXPECT_LT(score.median_translation, 0.03) << score.method;
  }
  EXPECT_THAT(pair_table(result), HasSubstr("modern start"));
  EXPECT_EQ(pair_json(result, small()).at("scores").size(), methods.size());
}

TEST(PairStudy, LeavesOutPairsThatShareLittle) {
  PairStudySettings settings = small();
  settings.min_overlap = 1.01;
  const auto source = open_log(kitchen);
  const PairStudyResult result = study_pairs(*source, pair_methods(), settings);
  EXPECT_EQ(result.little_overlap, 2);
  EXPECT_EQ(result.scores.front().pairs, 0);
}

TEST(PairStudy, RefusesWhatMakesNoSense) {
  const auto source = open_log(kitchen);
  PairStudySettings settings = small();
  settings.apart = {};
  EXPECT_THROW(study_pairs(*source, pair_methods(), settings), std::invalid_argument);
  settings = small();
  settings.max_translation = 0;
  EXPECT_THROW(study_pairs(*source, pair_methods(), settings), std::invalid_argument);
  settings = small();
  settings.apart = {5000};
  EXPECT_THROW(study_pairs(*source, pair_methods(), settings), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam

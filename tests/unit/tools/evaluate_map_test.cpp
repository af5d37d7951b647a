// lcmslam evaluate --map: what of a map's place and of its surfaces must be known.

#include <fstream>

#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/evaluate_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class EvaluateMap : public testing::Evaluate {
 protected:
  const std::string scene_ = source_folder() / "config/scenes/kitchen.yaml";
};

TEST_F(EvaluateMap, AMapWithoutPointsHasNoError) {
  write_log("run.lcmlog");
  std::ofstream(path("map.ply")) << "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n"
                                    "property float y\nproperty float z\nend_header\n";
  ASSERT_EQ(run({path("run.lcmlog"), "--map", path("map.ply"), "--scene", scene_, "--json", path("r.json")}),
            0)
      << output_;
  EXPECT_THAT(output_, AllOf(HasSubstr("0 points"), HasSubstr("median - m, 95 % within - m, mean - m")));
  for (const char* figure : {"median_m", "p95_m", "mean_m", "beyond_share"})
    EXPECT_TRUE(json("r.json").at("map").at(figure).is_null()) << figure;
}

}  // namespace
}  // namespace lcmslam

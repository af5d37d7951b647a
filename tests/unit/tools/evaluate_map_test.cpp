// lcmslam evaluate --map: what of a map's place and of its surfaces must be known.

#include <fstream>

#include <lcmslam/map_store/map_export.hpp>
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

TEST_F(EvaluateMap, AScaledPathPlacesNoMap) {
  write_log("run.lcmlog");
  save_ply(std::filesystem::path(path("map.ply")), ColouredCloud());
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--map", path("map.ply"), "--scene", scene_}, {"--walls", scene_}}) {
    std::vector<std::string> arguments = {path("run.lcmlog"), "--alignment", "sim3"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    EXPECT_EQ(run(arguments), -1);
    EXPECT_THAT(output_, AllOf(HasSubstr(options[0]), HasSubstr("use se3")));
  }
}

}  // namespace
}  // namespace lcmslam

#include <lcmslam/messages/geometry_messages.hpp>

#include <gmock/gmock.h>

#include <cmath>

#include "tests/unit/messages/error_of.hpp"

namespace lcmslam {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

const double nan = std::nan("");

TEST(GeometryMessages, QuaternionOfNearlyUnitLengthIsNormalised) {
  rigid_transform_t m = to_message(Eigen::Isometry3d::Identity());
  m.quat[0] = 1.0003;
  const Eigen::Isometry3d T = from_message(m, "T");
  EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
}

TEST(GeometryMessages, ReadsBotCoresPose) {
  pose_t m{};
  m.pos[1] = 2;
  m.orientation[0] = m.orientation[3] = std::sqrt(0.5);  // w, z: a quarter turn to the left
  const Eigen::Isometry3d T = from_message(m);
  EXPECT_TRUE((T * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(0, 3, 0), 1e-12));
  m.orientation[0] = 3;
  EXPECT_THAT(error_of([&] { from_message(m); }), HasSubstr("pose_t"));
}

TEST(GeometryMessages, RangeCheckNamesFieldValueAndLimits) {
  EXPECT_NO_THROW(check_range(1, 1, 1, "x"));
  EXPECT_THAT(error_of([] { check_range(2.5, -1, 2, "speed"); }),
              ::testing::AllOf(HasSubstr("speed"), HasSubstr("2.5"), HasSubstr("-1.0"), HasSubstr("2.0")));
  EXPECT_THAT(error_of([] { check_range(nan, -1, 2, "speed"); }), HasSubstr("nan"));
}

}  // namespace
}  // namespace lcmslam

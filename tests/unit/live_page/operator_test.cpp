#include <gtest/gtest.h>
#include <cmath>
#include <stdexcept>

#include <lcmslam/live_page/dead_man.hpp>
#include <lcmslam/live_page/truth_error.hpp>

namespace lcmslam {
namespace {

TEST(DeadMan, StopsOnceWhoFallsSilent) {
  DeadMan dead_man(0.3);
  EXPECT_EQ(dead_man.drive(1, {0.5, -0.2}, 10).linear, 0.5);
  EXPECT_FALSE(dead_man.silent(10.29));
  dead_man.drive(1, {0.5, 0}, 10.2);
  EXPECT_FALSE(dead_man.silent(10.45));
  const auto stop = dead_man.silent(10.5);
  ASSERT_TRUE(stop);
  EXPECT_TRUE(stop->stops());
  EXPECT_FALSE(dead_man.silent(20));
  EXPECT_FALSE(dead_man.is_driving());
}

TEST(DeadMan, StopsWhoIsGoneAndNobodyElse) {
  DeadMan dead_man;
  dead_man.drive(1, {1, 0}, 0);
  EXPECT_FALSE(dead_man.gone(2));
  ASSERT_TRUE(dead_man.gone(1));
  EXPECT_FALSE(dead_man.gone(1));
}

TEST(DeadMan, WhoTakesOverStopsFirst) {
  DeadMan dead_man;
  dead_man.drive(1, {1, 0}, 0);
  EXPECT_TRUE(dead_man.drive(2, {-1, 0}, 0.1).stops());
  EXPECT_EQ(dead_man.drive(2, {-1, 0}, 0.2).linear, -1);
}

TEST(DeadMan, WhoWasOustedMustLetGoFirst) {
  DeadMan dead_man(0.3);
  dead_man.drive(1, {1, 0}, 0);
  dead_man.drive(2, {-1, 0}, 0.1);
  for (const double now : {0.11, 0.12, 0.3, 0.5})
    EXPECT_THROW(dead_man.drive(1, {1, 0}, now), std::runtime_error)
        << "whatever the links do with their words";
  EXPECT_EQ(dead_man.drive(2, {-1, 0}, 0.55).linear, -1);
  EXPECT_TRUE(dead_man.drive(1, {0, 0}, 0.6).stops());
  EXPECT_EQ(dead_man.drive(2, {-1, 0}, 0.65).linear, -1) << "a stop is for that moment";
  EXPECT_TRUE(dead_man.drive(1, {1, 0}, 0.7).stops()) << "a new press takes over";
  EXPECT_THROW(dead_man.drive(2, {-1, 0}, 0.75), std::runtime_error);
  EXPECT_EQ(dead_man.drive(1, {1, 0}, 0.8).linear, 1);
  EXPECT_EQ(dead_man.drive(2, {-1, 0}, 1.5).linear, 0) << "who was silent has let go";
}

TEST(DeadMan, SharesAreBoundedAndMustBeNumbers) {
  DeadMan dead_man;
  EXPECT_EQ(dead_man.drive(1, {7, -7}, 0).linear, 1);
  EXPECT_EQ(dead_man.drive(1, {7, -7}, 0).angular, -1);
  EXPECT_THROW(dead_man.drive(1, {NAN, 0}, 0), std::invalid_argument);
  dead_man.drive(1, {0, 0}, 0);
  EXPECT_FALSE(dead_man.is_driving());
}

TEST(TruthError, CountsFromWhereBothMet) {
  TruthError errors;
  const Eigen::Isometry3d T_world_map = planar_pose(3, -2, 1);
  for (int i = 0; i < 20; ++i) errors.truth(100'000 * i, T_world_map * planar_pose(0.1 * i, 0, 0.02 * i));
  EXPECT_NEAR(*errors.error("icp", "map", 0, planar_pose(0, 0, 0)), 0, 1e-12);
  EXPECT_NEAR(*errors.error("icp", "map", 1'000'000, planar_pose(1, 0.05, 0.2)), 0.05, 1e-9);
  EXPECT_NEAR(*errors.error("icp", "map", 1'050'000, planar_pose(1.05, 0, 0.21)), 0, 1e-3) << "between two";
  EXPECT_FALSE(errors.error("icp", "map", 2'000'000, planar_pose(2, 0, 0))) << "not known yet";
  EXPECT_TRUE((*errors.in_map("icp", T_world_map)).isApprox(Eigen::Isometry3d::Identity(), 1e-9));
  EXPECT_FALSE(errors.in_map("fastslam", T_world_map));
}

TEST(TruthError, AnotherMapIsMetAnewAndTimeMayBeginAnew) {
  TruthError errors;
  errors.truth(1000, planar_pose(0, 0, 0));
  errors.error("icp", "map", 1000, planar_pose(0, 0, 0));
  EXPECT_NEAR(*errors.error("icp", "map-2", 1000, planar_pose(5, 0, 0)), 0, 1e-12);
  errors.truth(500, planar_pose(1, 0, 0));
  EXPECT_FALSE(errors.error("icp", "map-2", 1000, planar_pose(0, 0, 0)));
}

}  // namespace
}  // namespace lcmslam

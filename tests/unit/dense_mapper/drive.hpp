#pragma once
// What tests drive a mapper with.

#include <gtest/gtest.h>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

inline void expect_pose(const Eigen::Isometry3d& found, const Eigen::Isometry3d& truth, double metres,
                        double radians) {
  const Eigen::Isometry3d e = truth.inverse() * found;
  EXPECT_LT(e.translation().norm(), metres);
  EXPECT_LT(rotation_angle(e), radians);
}

const Eigen::Isometry3d no_mount = Eigen::Isometry3d::Identity();
constexpr Utime frame_time = 100'000;

}  // namespace lcmslam

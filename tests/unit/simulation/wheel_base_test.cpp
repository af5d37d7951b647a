#include <lcmslam/simulation/wheel_base.hpp>

#include <gmock/gmock.h>

#include <Eigen/QR>

#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

/// Ideal kinematics, by least squares over all wheels: each step's readings to a twist, twists to a pose.
/// Returns the pose after each reading, from the identity.
std::vector<Eigen::Isometry3d> integrate(const std::vector<Encoders>& readings) {
  std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d::Identity()};
  for (std::size_t k = 1; k < readings.size(); ++k) {
    const auto& wheels = readings[k].wheels;
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(2 * wheels.size()), 3);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows());
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      const Wheel& wheel = wheels[i];
      const double travel = wheel.radius * (wheel.angle - readings[k - 1].wheels[i].angle);
      const double c = std::cos(wheel.steering), s = std::sin(wheel.steering),
                   t = std::tan(wheel.roller_angle);
      const Eigen::RowVector3d x(1, 0, -wheel.y), y(0, 1, wheel.x);  // contact velocity from the twist
      const Eigen::RowVector3d along = c * x + s * y, across = c * y - s * x;
      A.row(static_cast<Eigen::Index>(2 * i)) = along + t * across;
      b[static_cast<Eigen::Index>(2 * i)] = travel;
      if (t == 0) A.row(static_cast<Eigen::Index>(2 * i + 1)) = across;
    }
    const Eigen::Vector3d twist = A.completeOrthogonalDecomposition().solve(b);
    Vector6d xi = Vector6d::Zero();
    xi << twist.x(), twist.y(), 0, 0, 0, twist.z();
    poses.push_back(poses.back() * se3_exp(xi));
  }
  return poses;
}

PlanarPath winding_path(bool holonomic) {
  return PlanarPath({{0, 0}, {1, 0}, {2, 0}, {3, 1}, {3, 2}, {2, 3}, {1, 3}, {0, 2}, {0, 1}, {1, 0}, {2, 0}},
                    {}, {holonomic ? 0.35 : 0.0, 6.0});
}

double path_heading_change(const PlanarPath& path) {
  double sum = 0;
  for (double t = 0; t < path.duration(); t += 0.1) sum += yaw(path.pose(t).inverse() * path.pose(t + 0.1));
  return sum;
}

class WheelBase : public testing::TestWithParam<const char*> {};

TEST_P(WheelBase, WithoutErrorsIdealKinematicsGivesTheTruth) {
  const PlanarPath path = winding_path(is_holonomic(GetParam()));
  WheelErrors exact = WheelErrors::none();
  exact.quantum = 1e-7;
  const auto readings = simulate_encoders(path, GetParam(), 1'000'000, 1, exact);
  const auto poses = integrate(readings);
  for (std::size_t k = 0; k < poses.size(); k += 50) {
    const double t = static_cast<double>(readings[k].utime - 1'000'000) * 1e-6;
    const Eigen::Isometry3d error = (path.pose(0).inverse() * path.pose(t)).inverse() * poses[k];
    EXPECT_LT(error.translation().norm(), 0.002) << "at " << t << " s";
    EXPECT_LT(rotation_angle(error), 0.002) << "at " << t << " s";
  }
}

TEST_P(WheelBase, ReadingsComeAt50HzInWholeMillimetres) {
  const auto readings = simulate_encoders(winding_path(false), GetParam(), 1'000'000, 1);
  for (std::size_t k = 0; k < readings.size(); ++k) {
    EXPECT_EQ(readings[k].utime, 1'000'000 + static_cast<Utime>(k) * 20'000);
    EXPECT_EQ(readings[k].seq, static_cast<std::int64_t>(k));
    for (const Wheel& wheel : readings[k].wheels) {
      const double millimetres = wheel.angle * wheel.radius * 1000;
      EXPECT_NEAR(millimetres, std::round(millimetres), 1e-6);
    }
  }
}

TEST_P(WheelBase, StandsStillDuringTheRests) {
  const auto readings = simulate_encoders(winding_path(false), GetParam(), 0, 3);
  for (std::size_t i = 0; i < readings[0].wheels.size(); ++i) {
    EXPECT_EQ(readings[45].wheels[i].angle, 0);
    EXPECT_EQ(readings.back().wheels[i].angle, readings[readings.size() - 45].wheels[i].angle);
  }
}

INSTANTIATE_TEST_SUITE_P(Bases, WheelBase, testing::Values("differential", "steered", "mecanum"),
                         [](const auto& instance) { return std::string(instance.param); });

// On a straight line the final pose shows scale and drift; over seeds they must have the pinned sizes.
TEST(WheelErrors, ScaleAndDriftArePinned) {
  const double length = 20;
  const PlanarPath line({{0, 0}, {10, 0}, {length, 0}});
  WheelErrors errors;
  errors.slip_every = 0;
  std::vector<double> stretch, heading;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Eigen::Isometry3d end = integrate(simulate_encoders(line, "mecanum", 0, seed, errors)).back();
    double driven = 0;
    const auto poses = integrate(simulate_encoders(line, "mecanum", 0, seed, errors));
    for (std::size_t k = 1; k < poses.size(); ++k)
      driven += (poses[k - 1].inverse() * poses[k]).translation().x();
    stretch.push_back(std::abs(driven / length - 1));
    heading.push_back(yaw(end));
  }
  // 2 % +- a quarter, and 1 cm per root metre of noise: 0.2 % over 20 m.
  EXPECT_NEAR(moments(stretch).mean, 0.02, 0.002);
  EXPECT_NEAR(moments(heading).mean, 0, 3 * 0.039 / std::sqrt(60.0));
  EXPECT_NEAR(moments(heading).deviation, 0.5 * M_PI / 180 * std::sqrt(length), 0.012);
}

TEST(WheelErrors, RotationScaleIsPinned) {
  const PlanarPath path = winding_path(false);
  const double turned = path_heading_change(path);
  WheelErrors errors;
  errors.slip_every = errors.heading_drift = 0;
  std::vector<double> ratio;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto poses = integrate(simulate_encoders(path, "differential", 0, seed, errors));
    double sum = 0;
    for (std::size_t k = 1; k < poses.size(); ++k) sum += yaw(poses[k - 1].inverse() * poses[k]);
    ratio.push_back(std::abs(sum / turned - 1));
  }
  EXPECT_NEAR(moments(ratio).mean, 0.03, 0.003);
  EXPECT_GT(*std::min_element(ratio.begin(), ratio.end()), 0.02);
  EXPECT_LT(*std::max_element(ratio.begin(), ratio.end()), 0.04);
}

TEST(WheelErrors, SlipsOccurAboutEveryTenMetres) {
  const PlanarPath line({{0, 0}, {50, 0}, {100, 0}});
  WheelErrors errors = WheelErrors::none();
  errors.quantum = 1e-6;
  errors.slip_every = 10;
  int slips = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto poses = integrate(simulate_encoders(line, "differential", 0, seed, errors));
    double angle = 0;
    for (std::size_t k = 1; k < poses.size(); ++k) {
      const double turn = yaw(poses[k - 1].inverse() * poses[k]);
      if (std::abs(turn) > 1e-3) {
        angle += turn;
      } else if (angle != 0) {
        ++slips;
        EXPECT_GT(std::abs(angle), 0.99 * M_PI / 180);
        EXPECT_LT(std::abs(angle), 3.01 * M_PI / 180);
        angle = 0;
      }
    }
  }
  EXPECT_NEAR(slips / 5.0, 10, 1.5);
}

TEST(WheelErrors, SeedDecides) {
  const PlanarPath path = winding_path(false);
  const auto angle = [&](std::uint64_t seed) {
    return simulate_encoders(path, "differential", 0, seed).back().wheels[0].angle;
  };
  EXPECT_EQ(angle(4), angle(4));
  EXPECT_NE(angle(4), angle(5));
}

TEST(MakeWheels, RefusesUnknownBases) {
  try {
    make_wheels("hover");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("hover"));
    EXPECT_THAT(error.what(), testing::HasSubstr("differential, steered or mecanum"));
  }
}

}  // namespace
}  // namespace lcmslam

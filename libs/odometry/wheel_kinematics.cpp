#include <lcmslam/odometry/wheel_kinematics.hpp>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace lcmslam {
namespace {

constexpr double max_roller_angle = 1.4;  // rad; towards pi/2 a wheel measures nothing

double mid_steering(double a, double b) {
  return a + 0.5 * std::remainder(b - a, 2 * M_PI);
}

// Row (vx, vy, w) -> component of the contact's velocity along `direction`.
Eigen::RowVector3d contact_row(const Wheel& wheel, const Eigen::Vector2d& direction) {
  return {direction.x(), direction.y(), wheel.x * direction.y() - wheel.y * direction.x()};
}

}  // namespace

void check_wheels(const std::vector<Wheel>& wheels) {
  if (wheels.size() < 2) {
    throw std::invalid_argument("encoders of " + std::to_string(wheels.size()) +
                                " wheel(s); a base needs at least two");
  }
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    const Wheel& wheel = wheels[i];
    const auto fail = [&](const char* name, double value, const char* right) {
      throw std::invalid_argument("wheel " + std::to_string(i) + ": " + name + " is " +
                                  std::to_string(value) + "; expected " + right);
    };
    const std::pair<const char*, double> values[] = {
        {"x", wheel.x},           {"y", wheel.y},
        {"radius", wheel.radius}, {"roller_angle", wheel.roller_angle},
        {"angle", wheel.angle},   {"steering", wheel.steering}};
    for (const auto& [name, value] : values) {
      if (!std::isfinite(value)) fail(name, value, "a finite number");
    }
    if (wheel.radius <= 0) fail("radius", wheel.radius, "metres above 0");
    if (std::abs(wheel.roller_angle) > max_roller_angle) {
      fail("roller_angle", wheel.roller_angle, "radians from -1.4 to 1.4");
    }
  }
}

std::optional<Eigen::Vector2d> held_sideways_at(const std::vector<Wheel>& before,
                                                const std::vector<Wheel>& after) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int holding = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].roller_angle != 0 || before[i].steering != 0 || after[i].steering != 0) continue;
    sum += Eigen::Vector2d(after[i].x, after[i].y);
    ++holding;
  }
  return holding > 0 ? std::make_optional<Eigen::Vector2d>(sum / holding) : std::nullopt;
}

WheelFit fit_motion(const std::vector<Wheel>& before, const std::vector<Wheel>& after,
                    double side_slip_weight) {
  const auto max_rows = static_cast<Eigen::Index>(2 * after.size());
  Eigen::MatrixX3d A(max_rows, 3);
  Eigen::VectorXd b(max_rows);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(max_rows);
  Eigen::Index rows = 0;
  const auto add_row = [&](const Eigen::RowVector3d& row, double value, double weight = 1) {
    A.row(rows) = row;
    weights[rows] = weight;
    b[rows++] = value;
  };

  double reach = 0;  // m, scales the heading's column
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Wheel& wheel = after[i];
    const double steering = mid_steering(before[i].steering, wheel.steering);
    const Eigen::Vector2d rolling(std::cos(steering), std::sin(steering));
    const Eigen::Vector2d axle(-rolling.y(), rolling.x());
    const double rolled = wheel.radius * (wheel.angle - before[i].angle);
    reach = std::max(reach, std::hypot(wheel.x, wheel.y));
    if (wheel.roller_angle == 0) {
      add_row(contact_row(wheel, rolling), rolled);
      add_row(contact_row(wheel, axle), 0, side_slip_weight);
    } else {
      add_row(contact_row(wheel, rolling + std::tan(wheel.roller_angle) * axle), rolled);
    }
  }
  A.conservativeResize(rows, 3);
  b.conservativeResize(rows);

  A.col(2) /= std::max(reach, 1e-9);
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (rows < 3 || svd.singularValues()[2] < 1e-4 * svd.singularValues()[0]) {
    throw std::invalid_argument(
        "the wheels' places, steering and rollers do not determine the body's motion (vx, vy, w); "
        "check their x, y, steering and roller_angle");
  }

  // Whether they determine it is a matter of their places alone.
  A = weights.head(rows).asDiagonal() * A;
  b = weights.head(rows).asDiagonal() * b;
  if (side_slip_weight != 1) svd.compute(A, Eigen::ComputeThinU | Eigen::ComputeThinV);

  WheelFit fit;
  const Eigen::Vector3d scaled = svd.solve(b);
  const Eigen::Vector3d unscale(1, 1, 1 / std::max(reach, 1e-9));
  fit.motion = unscale.asDiagonal() * scaled;
  const double squares = (A * scaled - b).squaredNorm();
  fit.residual = std::sqrt(squares / static_cast<double>(rows));
  if (rows > 3) {
    const Eigen::Matrix3d inverse = (A.transpose() * A).inverse();
    fit.covariance =
        squares / static_cast<double>(rows - 3) * unscale.asDiagonal() * inverse * unscale.asDiagonal();
  }
  for (const Wheel& wheel : after) {
    fit.way_rolled +=
        std::hypot(fit.motion.x() - fit.motion.z() * wheel.y, fit.motion.y() + fit.motion.z() * wheel.x) /
        static_cast<double>(after.size());
  }
  return fit;
}

}  // namespace lcmslam

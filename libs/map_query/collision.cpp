#include <lcmslam/map_query/collision.hpp>

#include <algorithm>
#include <stdexcept>

namespace lcmslam {
namespace {

// In cells. Between centres of cells distances are interpolated, which near a single cell says too much.
constexpr double interpolation_error = 0.35;
constexpr double smallest_part = 0.3;  // radius

}  // namespace

CollisionChecker::CollisionChecker(std::vector<const DistanceField*> fields) : fields_(std::move(fields)) {
  if (fields_.empty()) throw std::invalid_argument("collision: no distance field; must be one at least");
  cell_size_ = fields_.front()->cell_size();
  for (const DistanceField* field : fields_)
    if (field->cell_size() != cell_size_)
      throw std::invalid_argument("collision: fields of different cell sizes; must be the same");
}

double CollisionChecker::distance(const Eigen::Vector3d& point) const {
  double nearest = fields_.front()->sample(point).distance;
  for (std::size_t i = 1; i < fields_.size(); ++i)
    nearest = std::min(nearest, fields_[i]->sample(point).distance);
  return nearest;
}

// Of the distance to the nearest occupied cell's centre. Cells' centres tell theirs exactly, and the point
// lies beside one; where a field is truncated that says only that nothing is nearer.
CollisionChecker::Bounds CollisionChecker::bounds(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d centre = ((point.array() / cell_size_).floor() + 0.5) * cell_size_;
  const Eigen::Vector3f asked = centre.cast<float>();
  double nearest = fields_.front()->cell_distance(asked);
  for (std::size_t i = 1; i < fields_.size(); ++i)
    nearest = std::min(nearest, fields_[i]->cell_distance(asked));
  const double beside = (point - centre).norm();
  return {nearest - beside, nearest + beside};
}

// `outside` tells how far a point is from the body, or less: parts that none of it is in do not count.
template <class Outside>
bool CollisionChecker::part_collides(const Box& part, const Outside& outside) const {
  const Eigen::Vector3d middle = part.T_map_box.translation();
  const double radius = part.half_size.norm(), reach = 0.5 * cell_size_;
  const double away = outside(middle);
  if (away > radius) return false;
  const Bounds nearest = bounds(middle);
  if (nearest.least > radius + reach) return false;
  if (away <= 0 && nearest.most <= reach) return true;
  if (radius <= smallest_part * cell_size_)
    return distance(middle) - interpolation_error * cell_size_ <= radius + reach;
  int axis = 0;
  part.half_size.maxCoeff(&axis);
  Box half = part;
  half.half_size[axis] /= 2;
  for (const double side : {-1.0, 1.0}) {
    half.T_map_box.translation() = middle + side * half.half_size[axis] * part.T_map_box.linear().col(axis);
    if (part_collides(half, outside)) return true;
  }
  return false;
}

bool CollisionChecker::collides(const Sphere& sphere) const {
  return collides(Capsule{sphere.centre, sphere.centre, sphere.radius});
}

bool CollisionChecker::collides(const Capsule& capsule) const {
  const Eigen::Vector3d way = capsule.to - capsule.from;
  const double length = way.norm();
  const Eigen::Vector3d direction = length > 0 ? Eigen::Vector3d(way / length) : Eigen::Vector3d(1, 0, 0);
  Box around{Eigen::Isometry3d::Identity(), Eigen::Vector3d::Constant(capsule.radius)};
  around.half_size.x() += length / 2;
  around.T_map_box.translation() = (capsule.from + capsule.to) / 2;
  around.T_map_box.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), direction).toRotationMatrix();
  return part_collides(around, [&](const Eigen::Vector3d& p) {
    const double along = std::clamp((p - capsule.from).dot(direction), 0.0, length);
    return (p - capsule.from - along * direction).norm() - capsule.radius;
  });
}

bool CollisionChecker::collides(const Box& box) const {
  return part_collides(box, [](const Eigen::Vector3d&) { return 0.0; });
}

}  // namespace lcmslam

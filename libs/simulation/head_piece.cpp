#include <lcmslam/simulation/head_piece.hpp>

#include <cmath>

namespace lcmslam {

TofSensor HeadPiece::sensor(TofSensor model) const {
  if (unit_ > 0) model.wiggle_phase = stream(0).uniform(0, 2 * M_PI);
  return model;
}

// A board's size and flatness scale both focal lengths alike.
CameraModel HeadPiece::lens(CameraModel told, std::uint64_t part) const {
  if (unit_ == 0) return told;
  const double scale = 1 + stream(part).normal(0, focal_sigma);
  told.fx *= scale;
  told.fy *= scale;
  return told;
}

Eigen::Isometry3d HeadPiece::mount(const Eigen::Isometry3d& told) const {
  if (unit_ == 0) return told;
  Random draw = stream(4);
  Vector6d error;
  for (int i = 0; i < 6; ++i) error(i) = draw.normal(0, i < 3 ? translation_sigma : rotation_sigma);
  return told * se3_exp(error);
}

Utime HeadPiece::clock() const {
  return unit_ == 0 ? 0 : static_cast<Utime>(std::llround(1e6 * stream(5).normal(0, clock_sigma)));
}

}  // namespace lcmslam

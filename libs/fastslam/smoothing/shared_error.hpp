#pragma once
// What the particles' spread does not show: the error that all of them share. A hundred particles forget what
// they did not know of their past with every resampling (Bailey, Nieto and Nebot 2006, "Consistency of the
// FastSLAM algorithm"), but the map remembers it: a robot that stands among landmarks knows no better where
// it is than the robot knew that mapped them.
//
// So each landmark keeps the covariance B of the shared error when it was made, as of a twist of the world
// (left perturbation exp(xi) T), in which it holds for the landmark and whoever looks at it alike. Each of
// its n accepted observations so far came from a pose that erred by the spread L besides, independently, and
// the landmark is their mean. Over the landmarks in sight,
//
//   B = mean(B_landmark + L / n)
//
// since a mean of errors of unknown correlation has at most the mean of their covariances. What is found
// again after a loop brings its old, small covariance with it.

#include <vector>

#include <lcmslam/fastslam/association/association.hpp>

namespace lcmslam {

class SharedError {
 public:
  /// The pose, with its particles' spread (body frame), rests on these landmarks, and they learned from it:
  /// the more, the surer.
  void observe(const std::vector<LandmarkMatch>& accepted, int minimum_consensus,
               const Eigen::Isometry3d& T_world_robot, const Matrix6d& spread);
  /// Landmarks are made.
  void create(const std::vector<LandmarkMatch>& created);
  /// Its covariance in a pose's body frame.
  Matrix6d at(const Eigen::Isometry3d& T_world_robot) const;

 private:
  using Compact = Eigen::Matrix<float, 6, 6>;
  Matrix6d covariance_ = Matrix6d::Zero();  // B: of a twist of the world, m, rad
  struct Record {
    Compact made_at = Compact::Zero();
    int observations = 0;
  };
  std::vector<Record> landmarks_;  // by slot
};

}  // namespace lcmslam

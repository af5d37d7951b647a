// A camera that is covered, or too slow for its odometry: what the robot says while it cannot know where it
// is, and what it does with its map.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

using synthetic::Drive;
using synthetic::make_drive;

constexpr int lap = 225;  // frames; what was seen first comes into sight again

FastSlamSettings hand_held() {
  FastSlamSettings settings;
  settings.planar = false;
  return settings;
}

Drive hand_held_drive(int frames, std::uint64_t seed) {
  synthetic::WorldSettings world = synthetic::short_world(frames);
  world.full_motion = true;
  world.slips = false;
  Drive drive = make_drive(world, seed);
  for (synthetic::Step& step : drive.steps) step.motion.visual = true;
  return drive;
}

/// What a visual odometry says that has seen nothing for `before` s and goes on for `step` s: it stands, and
/// its error is that of an unknown acceleration, of the turn at most 1 rad.
Motion in_the_dark(double before, double step) {
  const auto sigma2 = [](double acceleration, double limit, double t) {
    return std::pow(std::min(limit, 0.5 * acceleration * t * t), 2);
  };
  Motion motion;
  motion.visual = true;
  motion.covariance.diagonal().head<3>().setConstant(sigma2(3, 1e9, before + step) - sigma2(3, 1e9, before));
  motion.covariance.diagonal().tail<3>().setConstant(sigma2(6, 1, before + step) - sigma2(6, 1, before) +
                                                     1e-7);
  return motion;
}

Vector6d error_of(const StepResult& result, const synthetic::Step& step) {
  return se3_log(result.T_world_robot.inverse() * step.T_start_robot);
}

double nees(const StepResult& result, const synthetic::Step& step) {
  const Vector6d error = error_of(result, step);
  return error.dot(result.covariance.ldlt().solve(error));
}

TEST(CoveredCamera, StandsLostMapsNothingAndFindsBack) {
  constexpr std::size_t covered = 120, uncovered = 170;
  constexpr double dt = 0.1;  // s between frames
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    Drive drive = hand_held_drive(lap + 50, seed);
    FastSlam slam(hand_held());
    Eigen::Isometry3d T_last_seen;
    double worst_nees = 0, sigma = 0;
    int landmarks = 0;
    bool found = false;
    for (std::size_t i = 0; i < drive.steps.size(); ++i) {
      synthetic::Step& step = drive.steps[i];
      const bool dark = i >= covered && i < uncovered;
      if (dark) step.frame.features.clear();
      const double dark_for = dark ? dt * static_cast<double>(i - covered) : 0;
      const StepResult r = slam.step(dark ? in_the_dark(dark_for, dt) : step.motion, step.frame);
      if (i + 1 == covered) {
        T_last_seen = r.T_world_robot;
        landmarks = slam.index().size();
      } else if (dark) {
        EXPECT_LT((r.T_world_robot.translation() - T_last_seen.translation()).norm(), 0.01) << i;
        EXPECT_TRUE(r.status == TrackStatus::lost || (dark_for < 0.9 && r.status == TrackStatus::predicting))
            << i;
        EXPECT_GE(r.covariance.trace(), 0.999 * sigma) << i;  // a sample's
        EXPECT_EQ(slam.index().size(), landmarks) << i;
        sigma = r.covariance.trace();
        worst_nees = std::max(worst_nees, nees(r, step));
      } else if (i >= uncovered) {
        EXPECT_TRUE(found || r.status != TrackStatus::tracking) << i;
        if (found) {
          EXPECT_EQ(r.status, TrackStatus::tracking) << i;
          EXPECT_LT(r.covariance.trace(), 0.01) << i;
        }
        found |= r.status == TrackStatus::relocalised;
        if (r.status == TrackStatus::tracking || r.status == TrackStatus::relocalised) {
          EXPECT_LT(error_of(r, step).head<3>().norm(), 0.1) << i;
        } else {
          EXPECT_EQ(r.created, 0) << i;
        }
      }
    }
    std::cout << "seed " << seed << ": worst NEES in the dark " << worst_nees << "\n";
    EXPECT_LT(worst_nees, 12);
    EXPECT_GT(sigma, 1);
    EXPECT_TRUE(found);
  }
}

// Found back while odometry still knows nothing: that is news of the map. A controller, who follows the local
// pose, sees no more than a robot can do in one step.
TEST(CoveredCamera, BeingFoundIsNoMotion) {
  constexpr std::size_t covered = 120, uncovered = 135, elsewhere = 60;  // where it is carried meanwhile
  constexpr double dt = 0.1;                                             // s between frames
  const Drive drive = hand_held_drive(lap + 50, 1);
  FastSlam slam(hand_held());
  Eigen::Isometry3d T_last, T_local_last;
  double leap = 0, local_leap = 0;
  bool found = false;
  for (std::size_t i = 0; i < drive.steps.size() && !found; ++i) {
    const synthetic::Step& step = drive.steps[i];
    FeatureFrame frame = i < uncovered ? step.frame : drive.steps[elsewhere + i - uncovered].frame;
    frame.utime = step.frame.utime;
    if (i >= covered && i < uncovered) frame.features.clear();
    const bool unknown = i >= covered;
    const double dark_for = unknown ? dt * static_cast<double>(i - covered) : 0;
    const StepResult r = slam.step(unknown ? in_the_dark(dark_for, dt) : step.motion, frame);
    if (unknown) {
      leap = std::max(leap, distance_between(T_last, r.T_world_robot));
      local_leap = std::max(local_leap, distance_between(T_local_last, r.T_local_robot));
    }
    found = i >= uncovered && r.status == TrackStatus::relocalised;
    T_last = r.T_world_robot;
    T_local_last = r.T_local_robot;
  }
  ASSERT_TRUE(found);
  EXPECT_GT(leap, 0.5) << "the case is hard";
  EXPECT_LT(local_leap, 3 * 0.5 * dt + 0.1);
}

// Wheels are an odometry that is there: it is followed, and the pose is known as well as it says.
TEST(CoveredCamera, FollowsTheWheels) {
  constexpr std::size_t covered = 60, uncovered = 110;
  Drive drive = make_drive(synthetic::short_world(130), 2);
  FastSlam slam({});
  double worst = 0, worst_nees = 0;
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    synthetic::Step& step = drive.steps[i];
    const bool dark = i >= covered && i < uncovered;
    if (dark) step.frame.features.clear();
    step.motion.covariance *= 9;  // a scale error goes the same way at each step
    const StepResult r = slam.step(step.motion, step.frame);
    if (!dark) continue;
    const double seconds = 1e-6 * static_cast<double>(step.frame.utime - drive.steps[covered].frame.utime);
    if (seconds < 0.5) {
      EXPECT_EQ(r.status, TrackStatus::predicting) << i;
    }
    if (seconds > 0.9) {
      EXPECT_EQ(r.status, TrackStatus::lost) << i << ", whatever the odometry knows";
    }
    worst = std::max(worst, error_of(r, step).head<3>().norm());
    // In the plane; the others are held.
    const Eigen::Vector3d error = PoseSpace<3>::reduce(error_of(r, step));
    const Eigen::Matrix3d P = PoseSpace<3>::reduce(r.covariance);
    worst_nees = std::max(worst_nees, error.dot(P.ldlt().solve(error)));
  }
  EXPECT_LT(worst, 0.2);
  EXPECT_LT(worst_nees, 12);
}

// A gap of a second leaves nobody with an idea of the motion. The map stays as it was.
TEST(CoveredCamera, AGapIsAGap) {
  constexpr std::size_t gap = 120, after = 160;
  const Drive drive = hand_held_drive(lap + 50, 4);
  FastSlam slam(hand_held());
  int landmarks = 0;
  bool found = false;
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    if (i >= gap && i < after) continue;
    const bool first = i == after;
    const StepResult r =
        slam.step(first ? unknown_motion(4'100'000) : drive.steps[i].motion, drive.steps[i].frame);
    if (i < gap) landmarks = slam.index().size();
    if (i >= after) {
      EXPECT_TRUE(found || r.status == TrackStatus::lost || r.status == TrackStatus::relocalised) << i;
      if (!found && r.status == TrackStatus::lost) {
        EXPECT_EQ(slam.index().size(), landmarks);
      }
      found |= r.status == TrackStatus::relocalised;
      if (found) {
        EXPECT_LT(error_of(r, drive.steps[i]).head<3>().norm(), 0.1) << i;
      }
    }
  }
  EXPECT_TRUE(found);
}

// Carried to another place of its room in the dark, time and again: it finds itself, and maps no room beside
// the room.
TEST(CoveredCamera, AKnownRoomIsNotMappedAnewAfterEachJump) {
  constexpr int passes = 6, pass = 190;
  const Drive drive = hand_held_drive(passes * lap, 5);
  FastSlam slam(hand_held());
  std::vector<std::size_t> landmarks;
  for (int p = 0; p < passes; ++p) {
    int astray = 0;
    for (int i = 0; i < (p == 0 ? lap : pass); ++i) {
      const synthetic::Step& step = drive.steps[static_cast<std::size_t>(p * lap + i)];
      const bool jumped = p > 0 && i == 0;
      const StepResult r = slam.step(jumped ? in_the_dark(0, 0.1 * (lap - pass)) : step.motion, step.frame);
      const bool sure = r.status == TrackStatus::tracking || r.status == TrackStatus::relocalised;
      astray += sure && error_of(r, step).head<3>().norm() > 0.1;
    }
    EXPECT_EQ(astray, 0) << p;
    landmarks.push_back(slam.landmarks().size());
  }
  for (const std::size_t count : landmarks) std::cout << count << " landmarks\n";
  EXPECT_LT(20 * landmarks.back(), 23 * landmarks[1]);
}

// Lost on the way to a room that it has not seen: good wheels or not, it knows nothing there, and counts how
// long, so that somebody may begin a map for that room. Its first room it knows again.
TEST(CoveredCamera, CountsHowLongItKnowsNothingOfWhatItSees) {
  constexpr std::size_t known = 150, strange = 50;  // frames
  const Drive first = make_drive(synthetic::short_world(lap), 6);
  const Drive other = make_drive(synthetic::short_world(strange), 7);
  FastSlam slam({});
  for (std::size_t i = 0; i < known; ++i)
    EXPECT_EQ(slam.step(first.steps[i].motion, first.steps[i].frame).adrift, 0) << i;
  const int landmarks = slam.index().size();
  Utime utime = first.steps[known - 1].frame.utime;
  for (std::size_t i = 0; i < strange; ++i) {
    synthetic::Step step = other.steps[i];
    const Utime elapsed = i == 0 ? 1'000'000 : 100'000;
    step.frame.utime = utime += elapsed;
    if (i == 20) step.frame.features.clear();
    const StepResult r = slam.step(i == 0 ? unknown_motion(elapsed) : step.motion, step.frame);
    EXPECT_EQ(r.status, TrackStatus::lost) << i;
    EXPECT_NEAR(r.adrift, 1 + 0.1 * static_cast<double>(i >= 20 ? i - 1 : i), 1e-6) << i;
  }
  EXPECT_EQ(slam.index().size(), landmarks);
  double adrift = 1;
  for (std::size_t i = 20; i < 60 && adrift > 0; ++i) {
    synthetic::Step step = first.steps[i];
    step.frame.utime = utime += 100'000;
    adrift = slam.step(step.motion, step.frame).adrift;
  }
  EXPECT_EQ(adrift, 0) << "found";
}

// Somebody stands before a robot that stands, and leaves again: nobody has carried it.
TEST(CoveredCamera, WhoStandsBeforeARobotHasNotCarriedIt) {
  constexpr std::size_t stands = 60, hidden = 70, free_again = 130, end = 160;  // frames
  const Drive drive = make_drive(synthetic::short_world(stands), 8);
  synthetic::Step standing = drive.steps.back();
  const std::vector<Feature> room = standing.frame.features;
  std::vector<Feature> coat = room;
  Random random(9);
  for (Feature& feature : coat) {
    feature.point *= 0.4F;
    for (auto& byte : feature.descriptor) byte = static_cast<std::uint8_t>(random.below(200));
  }
  FastSlam slam({});
  for (const synthetic::Step& step : drive.steps) slam.step(step.motion, step.frame);
  standing.motion.T_from_to.setIdentity();
  for (std::size_t i = stands; i < end; ++i) {
    standing.frame.utime += 100'000;
    standing.frame.features = i >= hidden && i < free_again ? coat : room;
    for (Feature& feature : standing.frame.features) feature.x += static_cast<float>(0.3 * random.normal());
    const StepResult r = slam.step(standing.motion, standing.frame);
    EXPECT_EQ(r.unplaced, 0) << i;
    EXPECT_LT(error_of(r, standing).head<3>().norm(), 0.1) << i;
    if (i >= free_again + 10) {
      EXPECT_EQ(r.status, TrackStatus::tracking) << i;
    }
  }
}

// Most features lose their depth, those of a hall or in the sun: the others tell where the robot is.
TEST(CoveredCamera, FewFeaturesWithDepthAreNoContradiction) {
  constexpr std::size_t sparse = 60, end = 160;  // frames
  const Drive drive = make_drive(synthetic::short_world(end), 10);
  for (const std::size_t every : {4U, 8U}) {
    SCOPED_TRACE(every);
    FastSlam slam({});
    int confirmed = 0, lost = 0;
    for (std::size_t i = 0; i < end; ++i) {
      synthetic::Step step = drive.steps[i];
      for (std::size_t f = 0; f < step.frame.features.size() && i >= sparse; ++f)
        if (f % every != 0) step.frame.features[f].kind = MeasurementKind::bearing;
      const StepResult r = slam.step(step.motion, step.frame);
      EXPECT_EQ(r.unplaced, 0) << i;
      EXPECT_LT(error_of(r, step).head<3>().norm(), 0.1) << i;
      lost += r.status == TrackStatus::lost;
      confirmed += r.status == TrackStatus::predicting && r.used > 16;
    }
    std::cout << confirmed << " steps placed by features without depth, " << lost << " lost\n";
    EXPECT_LT(lost, 10) << "of 100";
  }
}

// Frames a second apart, and an odometry that is lost between the first ones: what was seen only once is no
// map to find back to. The world begins where the robot can follow its way, and holds from there.
TEST(SlowCamera, BeginsItsWorldWhereItCanFollow) {
  constexpr std::size_t lost_frames = 4, apart = 5;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const Drive drive = hand_held_drive(200, seed);
    FastSlam slam(hand_held());
    std::optional<Eigen::Isometry3d> T_start_world;
    int tracked = 0;
    for (std::size_t k = 0; k * apart < drive.steps.size(); ++k) {
      const synthetic::Step& step = drive.steps[k * apart];
      Motion motion;
      motion.T_from_to =
          drive.steps[k == 0 ? 0 : (k - 1) * apart].T_start_robot.inverse() * step.T_start_robot;
      motion.covariance = 1e-5 * Matrix6d::Identity();
      motion.visual = true;
      FeatureFrame frame = step.frame;
      if (k < lost_frames) frame = drive.steps[k * 40].frame;  // all show another wall
      frame.utime = step.frame.utime;
      const StepResult r = slam.step(k <= lost_frames ? in_the_dark(0, 0.5) : motion, frame);
      if (r.status == TrackStatus::initialising)
        T_start_world = step.T_start_robot * r.T_world_robot.inverse();
      if (r.status != TrackStatus::tracking) continue;
      ++tracked;
      const Eigen::Isometry3d T = *T_start_world * r.T_world_robot;
      EXPECT_LT((T.translation() - step.T_start_robot.translation()).norm(), 0.1) << k;
      EXPECT_LT(rotation_angle(T.inverse() * step.T_start_robot), 0.1) << k;
    }
    EXPECT_GT(tracked, 20);
  }
}

// Two or three images a second and no odometry at all: each shows much of what the one before did, and
// nobody was lost.
TEST(SlowCamera, IsNotLostBetweenTwoImages) {
  for (const std::size_t apart : {3U, 5U}) {
    SCOPED_TRACE(apart);
    const Drive drive = hand_held_drive(200, 2);
    FastSlam slam(hand_held());
    for (std::size_t i = 0; i < drive.steps.size(); i += apart) {
      const synthetic::Step& step = drive.steps[i];
      const StepResult r = slam.step(unknown_motion(static_cast<Utime>(100'000 * apart)), step.frame);
      EXPECT_EQ(r.status, i == 0 ? TrackStatus::initialising : TrackStatus::tracking) << i;
      EXPECT_LT(error_of(r, step).head<3>().norm(), 0.1) << i;
    }
  }
}

}  // namespace
}  // namespace lcmslam

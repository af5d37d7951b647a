// A step of the filter on the wire.

#include "procs/fastslam/step_messages.hpp"

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

TEST(StepMessages, ThePoseSaysHowMuchOfTheFrameItRestsOn) {
  StepResult result;
  result.T_world_robot = planar_pose(1, 2, 0);
  result.covariance = 0.25 * Matrix6d::Identity();
  result.offered = 2;  // the others have no depth
  result.matched = 9;
  result.rejected = 3;
  result.used = 3;
  result.slipped = true;
  result.status = TrackStatus::predicting;
  const pose_estimate_t pose = pose_message(77, result);
  EXPECT_EQ(pose.utime, 77);
  EXPECT_EQ(pose.status, pose_estimate_t::DEGRADED);
  EXPECT_FLOAT_EQ(pose.quality, 0.75F);
  EXPECT_EQ(pose.inliers, 3);
  EXPECT_EQ(pose.detail, "wheels slipped");
  EXPECT_EQ(pose_message(77, StepResult()).quality, 0);  // nothing known
  result.status = TrackStatus::lost;
  EXPECT_EQ(pose_message(77, result).status, pose_estimate_t::LOST);
  result.status = TrackStatus::relocalised;
  EXPECT_EQ(pose_message(77, result).status, pose_estimate_t::RELOCALISED);
}

TEST(StepMessages, AssociationsCarryTheFeaturesPixel) {
  FeatureFrame frame;
  frame.utime = 5;
  frame.features.resize(3);
  frame.features[2].x = 31;
  frame.features[2].y = 7;
  StepResult result;
  result.associations = {{2, 99, AssociationOutcome::created}, {0, 98, AssociationOutcome::unused}};
  const associations_t message = associations_message(frame, result);
  ASSERT_EQ(message.n_associations, 2);
  EXPECT_EQ(message.associations[0].feature, 2);
  EXPECT_EQ(message.associations[0].x, 31);
  EXPECT_EQ(message.associations[0].y, 7);
  EXPECT_EQ(message.associations[0].landmark, 99);
  EXPECT_EQ(message.associations[0].outcome, association_t::CREATED);
  EXPECT_EQ(message.associations[1].outcome, association_t::UNUSED);
}

TEST(StepMessages, ParticlesCarryTheirNormalisedWeights) {
  FastSlamSettings settings;
  settings.particles = 10;
  const FastSlam slam(settings);
  StepResult result;
  result.best = 4;
  result.effective_sample_size = 10;
  const particles_t message = particles_message(6, result, slam);
  ASSERT_EQ(message.n_particles, 10);
  EXPECT_EQ(message.total, 10);
  EXPECT_EQ(message.best, 4);
  for (const particle_t& particle : message.particles) EXPECT_FLOAT_EQ(particle.weight, 0.1F);
  EXPECT_FLOAT_EQ(message.particles[0].quat[0], 1);  // w x y z
}

}  // namespace
}  // namespace lcmslam

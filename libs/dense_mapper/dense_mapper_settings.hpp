#pragma once
// Settings of the dense mapper and all of its parts. Each part takes the whole and reads its own.

#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/dense_mapper/feature_anchor.hpp>
#include <lcmslam/dense_mapper/free_space.hpp>
#include <lcmslam/dense_mapper/map_target.hpp>
#include <lcmslam/dense_mapper/motion_prior.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_settings.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/geometry/mount_error.hpp>
#include <lcmslam/pose_graph/keyframe_graph.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include <lcmslam/rgbd/depth_clock.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct DenseMapperSettings {
  CloudFilterSettings filter;
  VoxelMapSettings map;
  MotionPriorSettings prior;
  FeatureAnchorSettings features;
  DepthClockSettings depth_clock;  // of whoever makes the frames
  KeyframeGraphSettings graph;
  FreeSpaceSettings free_space;
  MountErrorSettings mount_error;
  double stamp_sigma = 0.001;

  // registration: a coarse pass over few points from far, then a fine one
  double voxel_size = 0.04;
  CorrespondenceKind correspondence = CorrespondenceKind::voxel_map;
  double view_radius = 5;
  RegistrationSettings coarse = coarse_defaults();
  RegistrationSettings fine = fine_defaults();
  ColourOverlapSettings overlap;

  VariantKind variant = VariantKind::modern;
  ThesisSettings thesis;

  // trust
  int min_points = 200;
  double lost_overlap = 0.25;
  double good_overlap = 0.40;
  double good_inliers = 0.5;
  double max_jump = 0.30;
  double max_turn = 0.35;
  double max_disagreement = 5;
  int reseed_after = 10;
  double carried_after = 1;
  int recovery_keyframes = 3;

  // growth
  double insert_distance = 0.02;
  double insert_angle = 0.02;
  double keyframe_distance = 0.3;
  double keyframe_angle = 0.3;
  double keyframe_overlap = 0.5;
  double keyframe_voxel = 0.02;
  double keyframe_points = 6e6;
  int keyframe_features = 600;

  double deform_time = 0.05;
  double deform_time_per_surfel = 5e-7;

  void describe(SettingsVisitor& s);

  static RegistrationSettings coarse_defaults();
  static RegistrationSettings fine_defaults();

  /// Whether the passes' metric compares colours: then clouds must bring intensities.
  bool uses_colour() const { return coarse.colour_scale > 0 || fine.colour_scale > 0; }
  /// Whether a rejector compares images: then each step needs its own.
  bool compares_images() const { return coarse.colour_overlap || fine.colour_overlap; }
};

}  // namespace lcmslam

#pragma once
// Settings of the dense mapper and all of its parts. Each part takes the whole and reads its own.

#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/dense_mapper/feature_anchor.hpp>
#include <lcmslam/dense_mapper/free_space.hpp>
#include <lcmslam/dense_mapper/map_target.hpp>
#include <lcmslam/dense_mapper/motion_prior.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_settings.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/pose_graph/keyframe_graph.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include <lcmslam/rgbd/depth_clock.hpp>

namespace lcmslam {

struct DenseMapperSettings {
  CloudFilterSettings filter;
  VoxelMapSettings map;
  MotionPriorSettings prior;
  FeatureAnchorSettings features;
  DepthClockSettings depth_clock;  ///< of whoever makes the frames
  KeyframeGraphSettings graph;
  FreeSpaceSettings free_space;

  // registration: a coarse pass over few points from far, then a fine one
  double voxel_size = 0.04;  ///< m, of the cloud that is registered and inserted
  CorrespondenceKind correspondence = CorrespondenceKind::voxel_map;
  double view_radius = 5;  ///< m, of the map around the camera that k-d trees and projections show
  RegistrationSettings coarse = coarse_defaults();
  RegistrationSettings fine = fine_defaults();
  ColourOverlapSettings overlap;  ///< of the passes' colour_overlap

  VariantKind variant = VariantKind::modern;  ///< another one registers instead of both passes
  ThesisSettings thesis;

  // trust
  int min_points = 200;        ///< usable points after the voxel filter; fewer are no basis
  double lost_overlap = 0.25;  ///< below: lost
  double good_overlap = 0.40;  ///< below: degraded; also what a recovery must reach
  double good_inliers = 0.5;   ///< share of the pairs within three sigmas; below: degraded
  double max_jump = 0.30;      ///< m beyond the prediction: lost
  double max_turn = 0.35;      ///< rad beyond the prediction: lost
  int reseed_after = 10;       ///< bad frames after which odometry, if there is any, is believed
  int recovery_keyframes = 3;  ///< tried as starts in each frame while lost, without wheels

  // growth
  double insert_distance = 0.02;   ///< m between insertions
  double insert_angle = 0.02;      ///< rad
  double keyframe_distance = 0.3;  ///< m between keyframes
  double keyframe_angle = 0.3;     ///< rad
  double keyframe_overlap = 0.5;   ///< a keyframe is also due when less is known than this
  double keyframe_voxel = 0.02;    ///< m, of the keyframe's cloud
  /// Points that all keyframes keep together (31 bytes each: 190 MB). Beyond, the clouds farthest away are
  /// thinned, step by step.
  double keyframe_points = 6e6;
  int keyframe_features = 600;  ///< strongest of a keyframe that are kept

  // deforming the map takes as long, s of message time
  double bend_time = 0.05;
  double bend_time_per_surfel = 5e-7;

  static RegistrationSettings coarse_defaults();
  static RegistrationSettings fine_defaults();

  /// Whether the passes' metric compares colours: then clouds must bring intensities.
  bool uses_colour() const { return coarse.colour_scale > 0 || fine.colour_scale > 0; }
  /// Whether a rejector compares images: then each frame needs its own.
  bool compares_images() const { return coarse.colour_overlap || fine.colour_overlap; }
};

}  // namespace lcmslam

#pragma once
// One of two images that are registered to each other, for studies of pairs.

#include <opencv2/core.hpp>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {

/// One image as registration sees it, all in its colour camera's frame.
struct PairView {
  Utime utime = 0, depth_utime = 0;  ///< us, on the colour camera's clock
  cv::Mat colour;                    ///< CV_8UC3
  CameraModel camera, depth_camera;
  Eigen::Isometry3d T_camera_depth = Eigen::Isometry3d::Identity();
  Cloud cloud;  ///< thinned, with normals and sigmas
  FeatureFrame features;
};

/// `registration` with the frame's calibration; depth is filtered, the cloud thinned to voxels of this size
/// (m).
PairView make_pair_view(const RgbdFrame& frame, const DepthRegistration& registration, double voxel_size,
                        Surf& surf);

/// Share of the source's points that have a neighbour in the target within `reach` (m) at T_target_source.
double pair_overlap(const PairView& source, const PairView& target, const Eigen::Isometry3d& T, double reach);

}  // namespace lcmslam

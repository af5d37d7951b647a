#include "tools/study/pair_view.hpp"

#include <algorithm>

#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>

namespace lcmslam {

PairView make_pair_view(const RgbdFrame& frame, const DepthRegistration& registration, double voxel_size,
                        Surf& surf) {
  const RgbdCalibration& calibration = registration.calibration();
  PairView view;
  view.utime = frame.utime;
  view.depth_utime = calibration.depth_time(frame.depth_utime);
  view.colour = frame.colour;
  view.camera = calibration.colour;
  view.depth_camera = calibration.depth_registered ? calibration.colour : calibration.depth;
  if (!calibration.depth_registered) view.T_camera_depth = calibration.T_colour_depth;
  view.features = describe_frame(frame, registration(frame), calibration, surf);
  RgbdFrame filtered = frame;
  filtered.depth = frame.depth.clone();
  DepthFilter filter(calibration);
  filter(filtered.depth, frame.amplitude);
  const ColouredCloud cloud = make_cloud(filtered, registration(filtered), 2, true);
  view.cloud = voxel_filtered(geometry_of(usable_points(cloud)), voxel_size);
  return view;
}

double pair_overlap(const PairView& source, const PairView& target, const Eigen::Isometry3d& T,
                    double reach) {
  const KdTreeTarget tree(target.cloud);
  const Eigen::Isometry3f T_float = T.cast<float>();
  TargetPoint found;
  const auto near = std::count_if(source.cloud.points.begin(), source.cloud.points.end(), [&](const auto& p) {
    return tree.find(T_float * p, static_cast<float>(reach), found);
  });
  return source.cloud.size() > 0 ? static_cast<double>(near) / static_cast<double>(source.cloud.size()) : 0;
}

}  // namespace lcmslam

#pragma once
// Every type of lcmtypes/, for tests that hold for all of them.

#include <gtest/gtest.h>

#include <lcmslam/association_t.hpp>
#include <lcmslam/associations_t.hpp>
#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/camera_intrinsics_t.hpp>
#include <lcmslam/command_t.hpp>
#include <lcmslam/encoders_t.hpp>
#include <lcmslam/feature_t.hpp>
#include <lcmslam/features_t.hpp>
#include <lcmslam/graph_covariance_t.hpp>
#include <lcmslam/graph_edge_t.hpp>
#include <lcmslam/graph_node_t.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/ground_truth_t.hpp>
#include <lcmslam/icp_report_t.hpp>
#include <lcmslam/image_metadata_t.hpp>
#include <lcmslam/image_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/input_status_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmark_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/node_covariance_t.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/output_status_t.hpp>
#include <lcmslam/part_t.hpp>
#include <lcmslam/particle_t.hpp>
#include <lcmslam/particles_t.hpp>
#include <lcmslam/pointcloud2_t.hpp>
#include <lcmslam/pointfield_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/rigid_transform_t.hpp>
#include <lcmslam/status_t.hpp>
#include <lcmslam/twist_t.hpp>
#include <lcmslam/value_t.hpp>
#include <lcmslam/wheel_t.hpp>

namespace lcmslam::testing {

using AllTypes =
    ::testing::Types<association_t, associations_t, camera_calibration_t, camera_intrinsics_t, command_t,
                     encoders_t, feature_t, features_t, graph_covariance_t, graph_edge_t, graph_node_t,
                     graph_t, ground_truth_t, icp_report_t, image_metadata_t, image_t, images_t,
                     input_status_t, keyframe_t, landmark_t, landmarks_t, map_reply_t, map_request_t,
                     node_covariance_t, odometry_t, output_status_t, part_t, particle_t, particles_t,
                     pointcloud2_t, pointfield_t, pose_estimate_t, pose_t, rigid_transform_t, status_t,
                     twist_t, value_t, wheel_t>;

}  // namespace lcmslam::testing

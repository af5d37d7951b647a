#pragma once
#include <lcmslam/graph_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmark_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/messages/schema.hpp>
#include <lcmslam/node_covariance_t.hpp>

namespace lcmslam {

/// Largest message that needs no special receive buffer (docs/LCM.md).
constexpr std::size_t tile_bytes = 58'000;

landmark_t to_message(const Landmark& landmark);

/// One or more tiles; their origin and utime are set by the caller and the publisher.
std::vector<landmarks_t> make_landmark_tiles(Utime utime, std::int64_t revision, std::int64_t base_revision,
                                             const std::vector<Landmark>& landmarks,
                                             const std::vector<std::int64_t>& removed);
std::vector<Landmark> landmarks_of(const landmarks_t& message);

/// Positions in whole millimetres; points further than 32 m from the camera are left out.
/// `revision` (keyframe_t.map_revision) tells one publication of the keyframe from the next: a mapper counts
/// them.
std::vector<keyframe_t> make_keyframe_tiles(const DenseKeyframe& keyframe,
                                            const Eigen::Isometry3d& T_robot_camera, std::int64_t revision);
KeyframeTile from_message(const keyframe_t& message);

/// Where the graph has its nodes, as DenseMap::follow takes them.
std::vector<KeyframePose> from_message(const graph_t& message);

/// How wrong the pose of graph node `id` may be: of T exp(xi), m, rad, camera frame.
node_covariance_t to_message(std::int32_t id, const Matrix6d& covariance);
Matrix6d from_message(const node_covariance_t& message);

}  // namespace lcmslam

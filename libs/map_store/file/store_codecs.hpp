#pragma once
// What a map holds, to and from the blobs of its file. Every decode checks the blob (blob.hpp) and all of its
// values, and throws BlobError.

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/features/landmark.hpp>
#include <lcmslam/map_store/file/blob.hpp>
#include <lcmslam/map_store/file/stored_map.hpp>

namespace lcmslam {

/// Positions are rounded to this; what is farther than `farthest` from the camera, or not finite, comes back
/// as NaN.
constexpr double cloud_unit = 0.0001;  // m
constexpr double farthest = 100'000;   // m

/// Positions, colours and normals; normals to about half a degree, those that are unknown as NaN. No sigmas.
Blob encode_cloud(const ColouredCloud& cloud);
ColouredCloud decode_cloud(const Blob& blob);

/// The frame as it is.
Blob encode_features(const FeatureFrame& frame);
FeatureFrame decode_features(const Blob& blob);

/// Covariance, log-odds as floats, as they travel in messages.
/// Without amplitude. The images themselves are not decoded.
Blob encode_images(const StoredImages& images);
StoredImages decode_images(const Blob& blob);

Blob encode_landmark(const Landmark& landmark);
Landmark decode_landmark(const Blob& blob);

Blob encode_pose(const Eigen::Isometry3d& pose);
Eigen::Isometry3d decode_pose(const Blob& blob);

/// As floats.
Blob encode_covariance(const Matrix6d& covariance);
Matrix6d decode_covariance(const Blob& blob);

/// Without the ids.
Blob encode_edge(const StoredEdge& edge);
StoredEdge decode_edge(const Blob& blob);

Blob encode_trajectory(const std::vector<StoredPose>& poses);
std::vector<StoredPose> decode_trajectory(const Blob& blob);

Blob encode_bytes(const std::vector<std::uint8_t>& bytes);
std::vector<std::uint8_t> decode_bytes(const Blob& blob);

}  // namespace lcmslam

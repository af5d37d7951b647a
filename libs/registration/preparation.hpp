#pragma once
// What some parts of a registration need to know of a cloud beyond its points, from its neighbourhoods.

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/registration/registration_settings.hpp>

namespace lcmslam {

/// Sets the gradient of the intensity in each point's tangent plane, by least squares over `neighbours`; NaN
/// where normal or intensities are unknown. Needs normals and intensities.
void estimate_gradients(Cloud& cloud, int neighbours = 12);

/// Marks points around which the neighbours leave a gap of more than `gap` (rad) in the tangent plane;
/// without a normal nothing is marked.
void mark_boundary(Cloud& cloud, int neighbours = 16, double gap = 1.9);

/// The cloud with what the settings' metric and rejectors ask of a target (source) and it does not have yet.
/// Normals are turned towards `view_point` (m, the cloud's frame).
Cloud prepared_target(Cloud cloud, const RegistrationSettings& settings, const Eigen::Vector3d& view_point);
Cloud prepared_source(Cloud cloud, const RegistrationSettings& settings, const Eigen::Vector3d& view_point);

}  // namespace lcmslam

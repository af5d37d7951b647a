#pragma once
// What messages say, as the page draws it (docs/LIVE_PAGE.md).

#include <optional>

#include <lcmslam/associations_t.hpp>
#include <lcmslam/icp_report_t.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/live_page/health.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/particles_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/status_t.hpp>

namespace lcmslam {

/// x y z, then w x y z.
nlohmann::json page_pose(const Eigen::Isometry3d& T);
const char* page_status(int status);

/// A member of "poses".
nlohmann::json pose_member(const pose_estimate_t& pose);
nlohmann::json pose_member(const odometry_t& odometry, const Eigen::Isometry3d& T_map_robot);

/// Throws DecodeError for a best particle that is not there.
PageItem particles_item(const particles_t& message);
PageItem report_item(const icp_report_t& message);
/// `associations` of the same image, or null. Nothing where the frame has no colour image.
std::optional<PageItem> image_item(const EncodedFrame& frame, const associations_t* associations);

/// `age` s since it came.
ProcessSaid process_said(const status_t& status, double age);

}  // namespace lcmslam

#include <lcmslam/rgbd/rgbd_frame_maker.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <lcmslam/rgbd/camera_motion.hpp>
#include <lcmslam/rgbd/feature_depth.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include <lcmslam/rgbd/rolling_shutter.hpp>

namespace lcmslam {
namespace {

constexpr Utime same_moment = 1000;        // us
constexpr std::size_t features_kept = 32;  // frames; odometry may lag behind features

double seconds_between(Utime from, Utime to) {
  return 1e-6 * static_cast<double>(to - from);
}

/// Every so many-th row and column gives about so many points.
int step_for(std::size_t pixels, double points) {
  return std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(pixels) / points))));
}

}  // namespace

RgbdFrameMaker::RgbdFrameMaker(const RgbdFrameMakerSettings& settings)
    : settings_(settings), depth_clock_(settings.depth_clock) {}

void RgbdFrameMaker::calibrate(const RgbdCalibration& calibration) {
  registration_.emplace(calibration);
  depth_points_.emplace(registration_->calibration());
  filter_.emplace(calibration, settings_.depth_filter);
  range_error_.emplace(calibration, settings_.range_error);
}

const RgbdCalibration& RgbdFrameMaker::calibration() const {
  if (!calibrated()) throw std::logic_error("frame maker: calibrate() must come before frames");
  return registration_->calibration();
}

Utime RgbdFrameMaker::clock_correction() const {
  return static_cast<Utime>(std::lround(1e6 * depth_clock_.offset()));
}

RgbdFrameMaker::Prepared RgbdFrameMaker::prepare(RgbdFrame frame, LateColour late_colour) {
  const Utime depth_utime = calibration().depth_time(frame.depth_utime);
  Prepared prepared;
  prepared.needed = std::max({frame.utime, depth_utime, depth_utime + clock_correction()});
  if (!frame.depth.empty()) {
    (*filter_)(frame.depth, frame.amplitude);
    range_error_->learn(frame.depth, frame.depth_utime);
    range_error_->correct(frame.depth);
  }
  prepared.view = depth_points_->thinned(frame, step_for(frame.depth.total(), settings_.cloud_points));
  prepared.frame = std::move(frame);
  prepared.late_colour = std::move(late_colour);
  return prepared;
}

void RgbdFrameMaker::add(FeatureFrame features) {
  features_.push_back(std::move(features));
  while (features_.size() > features_kept) features_.pop_front();
}

bool RgbdFrameMaker::has_features(const Prepared& prepared) const {
  return std::any_of(features_.begin(), features_.end(),
                     [&](const FeatureFrame& f) { return f.utime == prepared.frame.utime; });
}

bool RgbdFrameMaker::awaits_features(const Prepared& prepared) const {
  return !has_features(prepared) &&
         std::none_of(features_.begin(), features_.end(),
                      [&](const FeatureFrame& f) { return f.utime > prepared.frame.utime; });
}

bool RgbdFrameMaker::hears_features(const Prepared& prepared) const {
  return !features_.empty() && seconds_between(features_.back().utime, prepared.frame.utime) < 1;
}

RgbdFrameMaker::Made RgbdFrameMaker::make(Prepared& prepared, const MotionBetween& motion_between,
                                          Utime previous) const {
  const RgbdCalibration& c = calibration();
  const RgbdFrame& images = prepared.frame;
  Made made;
  DenseFrame& frame = made.frame;

  // The moment: colour's time where images are of one moment, or motion joins them.
  made.depth_utime = c.depth_time(images.depth_utime);
  const Utime seen_utime = made.depth_utime + clock_correction();
  const bool together = std::abs(images.utime - seen_utime) < same_moment;
  const auto motion = together ? std::nullopt : motion_between(images.utime, seen_utime);
  const auto to_depth = motion_between(images.utime, made.depth_utime);
  Way way;
  way.joined = motion && to_depth;
  frame.utime = together || way.joined ? images.utime : made.depth_utime;
  if (frame.utime == images.utime && to_depth) made.T_frame_depth = to_depth->T_from_to;
  // Images of one moment are taken as they are, whatever is known of the clocks.
  if (together)
    made.added_to_depth = seconds_between(made.depth_utime, images.utime);
  else if (way.joined)
    made.added_to_depth = depth_clock_.offset();

  // The way of depth's points to it.
  if (way.joined) way.T_colour_depth_time = camera_motion(*motion, c.T_robot_camera);
  way.row_motion = row_motion(motion_between, previous, images.utime);

  // What stands there.
  frame.T_robot_camera = c.T_robot_camera;
  frame.noise_left = filter_->noise_left();
  frame.colouriser = [this, &prepared, way] { return colourise(prepared, way); };
  if (settings_.intensities) {
    const ColouredCloud coloured = frame.colouriser();
    frame.cloud = geometry_of(coloured);
    frame.cloud.intensities = intensities_of(coloured);
  } else {
    frame.cloud = cloud_of(prepared.view, way.T_colour_depth_time, way.row_motion);
  }
  const auto within = std::max(same_moment, static_cast<Utime>(1e6 * settings_.features_within));
  if (std::abs(frame.utime - images.utime) <= within) frame.features = features_at(prepared, way);
  frame.colour = ColourView{images.colour, c.colour, c.depth, c.T_colour_depth};
  return made;
}

Vector6d RgbdFrameMaker::row_motion(const MotionBetween& motion_between, Utime previous, Utime utime) const {
  const RgbdCalibration& c = calibration();
  if (!(c.rolling_shutter > 0) || utime <= previous) return Vector6d::Zero();
  const auto motion = motion_between(previous, utime);
  if (!motion) return Vector6d::Zero();
  const Vector6d twist = se3_log(camera_motion(*motion, c.T_robot_camera)) / seconds_between(previous, utime);
  return c.rolling_shutter * twist;
}

// Where colour cannot be had, the points are grey.
ColouredCloud RgbdFrameMaker::colourise(Prepared& prepared, const Way& way) const {
  RgbdFrame& frame = prepared.frame;
  const CameraModel& camera = registration_->calibration().depth;
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  // Where registration compares colours, its cloud is the coloured one.
  const int step = settings_.intensities ? prepared.view.step : step_for(pixels, settings_.keyframe_points);
  if (frame.colour.empty() && prepared.late_colour) frame.colour = std::exchange(prepared.late_colour, {})();
  RegisteredDepth depth = (*registration_)(frame, way.T_colour_depth_time, step);
  straighten_rows(depth.points, way.row_motion);
  return make_cloud(frame, depth, step, frame.colour.empty());
}

std::optional<FeatureFrame> RgbdFrameMaker::features_at(const Prepared& prepared, const Way& way) const {
  const auto found = std::find_if(features_.begin(), features_.end(), [&](const FeatureFrame& features) {
    return features.utime == prepared.frame.utime;
  });
  if (found == features_.end()) return std::nullopt;
  FeatureFrame placed = *found;
  if (way.joined) {
    const RgbdCalibration& c = calibration();
    placed = placed_by(*depth_points_, prepared.frame, (way.T_colour_depth_time * c.T_colour_depth).inverse(),
                       *found, way.T_colour_depth_time);
  }
  straighten_rows(placed, way.row_motion);
  return placed;
}

void RgbdFrameMaker::observe(const Eigen::Isometry3d& T_world_features,
                             const Eigen::Isometry3d& T_world_cloud, const Motion& motion, double seconds,
                             const std::optional<double>& added_to_depth) {
  if (!(seconds > 0) || !added_to_depth) return;
  depth_clock_.add(T_world_features, T_world_cloud, so3_log(motion.T_from_to.linear()) / seconds,
                   *added_to_depth);
}

}  // namespace lcmslam

#include "tools/evaluate/evaluation_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/evaluation/map_placement.hpp>
#include <lcmslam/evaluation/table.hpp>

namespace lcmslam {
namespace {

double degrees(double radians) {
  return radians * 180 / M_PI;
}

std::vector<std::string> row(const std::string& name, const EvaluatedEstimate& e, const TrajectoryReport& r) {
  const auto metres = [](const ErrorStatistics& s) { return fixed_number(s.rmse, 4); };
  const auto angle = [](const ErrorStatistics& s) { return fixed_number(degrees(s.rmse), 2); };
  return {name,
          std::to_string(r.estimate_poses),
          std::to_string(r.matched_poses),
          fixed_number(100 * r.tracked_fraction, 1),
          fixed_number(r.absolute.translation.rmse, 6),
          fixed_number(r.absolute.translation.median, 4),
          fixed_number(r.absolute.translation.maximum, 4),
          angle(r.absolute.rotation),
          metres(r.per_frame.translation),
          angle(r.per_frame.rotation),
          fixed_number(r.per_frame.translation.maximum, 4),
          fixed_number(degrees(r.per_frame.rotation.maximum), 2),
          metres(r.per_second.translation),
          angle(r.per_second.rotation),
          metres(r.per_metre.translation),
          angle(r.per_metre.rotation),
          fixed_number(r.alignment.scale, 4),
          std::to_string(e.path.lost)};
}

Table error_table(const Evaluation& evaluation) {
  Table table({"estimate", "poses", "matched", "tracked %", "ATE rmse m", "median", "max", "deg",
               "RPE frame m", "deg", "max", "deg", "second m", "deg", "metre m", "deg", "scale", "lost"});
  for (const EvaluatedEstimate& e : evaluation.estimates) {
    if (e.report) {
      table.add(row(e.path.name, e, *e.report));
    } else {
      std::vector<std::string> empty(18, "-");
      empty[0] = e.path.name;
      empty[1] = std::to_string(e.path.trajectory.size());
      table.add(empty);
    }
    if (e.clocked) table.add(row(fmt::format("  clock {:+.1f} ms", 1e3 * e.clock->offset), e, *e.clocked));
  }
  return table;
}

std::string clock_text(const EvaluatedEstimate& e) {
  const ClockOffset& c = *e.clock;
  std::string text = fmt::format(
      "{}: clock offset {:+.1f} ms ({} poses compared; the error is within 5 % of its least from {:+.1f} to "
      "{:+.1f} ms): ATE {:.6f} m without it, {:.6f} m with it\n",
      e.path.name, 1e3 * c.offset, c.compared_poses, 1e3 * c.low, 1e3 * c.high,
      e.report->absolute.translation.rmse, e.clocked->absolute.translation.rmse);
  text += c.determined ? fmt::format("  not applied above; --clock-offset {:.4f} applies it\n", c.offset)
                       : "  this motion does not determine the offset: do not use it\n";
  return text;
}

std::string consistency_text(const EvaluatedEstimate& e) {
  const Consistency& c = *e.report->consistency;
  const std::size_t all = e.report->matched_poses, judged = c.nees.count;
  std::string text = fmt::format(
      "{}: consistency of its covariances{}: NEES median {:.1f}, mean {:.1f} ({} when honest, more: "
      "overconfident); "
      "within 95 %: {:.0f} % of the poses, {:.0f} % of the positions",
      e.path.name, judged == all ? "" : fmt::format(" (of {} of {} poses, others bring none)", judged, all),
      c.nees.median, c.nees.mean, c.components, 100 * c.inside, 100 * c.position_inside);
  text += fmt::format("; errors over their sigmas, {}: {:.2f}",
                      c.components == 3 ? "x, y, yaw" : "x, y, z, roll, pitch, yaw",
                      fmt::join(c.error_over_sigma, ", "));
  const double angle = rotation_angle(c.T_estimate_truth), lever = c.T_estimate_truth.translation().norm();
  if (angle > 0 || lever > 0)
    text += fmt::format(", with the truth's body {:.2f} degrees and {:.1f} mm beside the estimate's",
                        degrees(angle), 1e3 * lever);
  return text + "\n";
}

/// What to say so that the two speak of one body.
std::string body_advice(const BodyOffset& offset) {
  switch (body_pair(offset)) {
    case BodyPair::truth_is_camera:
      return "The truth's are a camera's axes (x right, y down, z forward), the estimate's a robot's (x "
             "forward, "
             "y left, z up): say --truth-frame camera --estimate-frame robot, with a log or --calibration "
             "FILE "
             "that tells where the camera sits";
    case BodyPair::estimate_is_camera:
      return "The estimate's are a camera's axes (x right, y down, z forward), the truth's a robot's (x "
             "forward, "
             "y left, z up): say --truth-frame robot --estimate-frame camera, with a log or --calibration "
             "FILE "
             "that tells where the camera sits";
    default:
      return "--truth-frame and --estimate-frame name camera and robot";
  }
}

std::string body_text(const EvaluatedEstimate& e) {
  const BodyOffset& o = *e.body;
  std::string text = e.path.name + ": the truth's poses are not those of the estimate's body";
  if (o.rotated) {
    const auto axes = o.axes();
    text += fmt::format(
        ", constantly turned by {:.1f} degrees ({:.1f} degrees vary): its x, y, z point along "
        "the estimate's {}, {}, {}",
        degrees(o.angle), degrees(o.scatter), axes[0], axes[1], axes[2]);
  }
  if (o.displaced)
    text += fmt::format(
        ", constantly {:.3f} m beside it (x, y, z = {:.3f}, {:.3f}, {:.3f}): position errors are "
        "{:.4f} m with that, {:.4f} m without",
        o.lever, o.T_estimate_truth.translation().x(), o.T_estimate_truth.translation().y(),
        o.T_estimate_truth.translation().z(), o.rmse_with, o.rmse_without);
  if (e.body_aligned) return text + ". That is taken away above (--align-bodies)\n";
  return text + ". The errors above hold that. " + body_advice(o) +
         "; --align-bodies takes away whatever is constant\n";
}

/// What a straight path's positions leave open. Empty where they tell it.
std::string turn_text(const EvaluatedEstimate& e, Alignment alignment) {
  constexpr double noticeable = 2;  // degrees
  const Eigen::Isometry3d T = map_place(e, alignment) * e.report->alignment.T_truth_estimate.inverse();
  const double angle = degrees(rotation_angle(T));
  if (angle < noticeable || alignment != Alignment::se3) return "";
  return fmt::format(
      "{}: the path is so straight that its positions leave open how its world is turned about it; by its "
      "orientations {:.1f} degrees otherwise, which the first deg above holds. --map and --walls go by "
      "both\n",
      e.path.name, angle);
}

void evaluate_one(EvaluatedEstimate& e, const Trajectory& truth, const EvaluationSettings& settings,
                  bool align_bodies) {
  try {
    e.report = evaluate(truth, e.path.trajectory, settings);
    e.body = find_body_offset(e.report->matches);
    if (!e.body || !align_bodies) return;
    e.path.trajectory = in_other_frame(e.path.trajectory, e.body->T_estimate_truth);
    e.report = evaluate(truth, e.path.trajectory, settings);
    e.body_aligned = true;
  } catch (const std::invalid_argument& error) {
    e.problem = error.what();
  }
}

void find_clock(EvaluatedEstimate& e, const Trajectory& truth, EvaluationSettings settings,
                const ClockOffsetSearch& search) {
  try {
    const ClockOffset clock = estimate_clock_offset(truth, e.path.trajectory, settings, search);
    settings.clock_offset = clock.offset;
    e.clocked = evaluate(truth, e.path.trajectory, settings);
    e.clock = clock;
  } catch (const std::invalid_argument& error) {
    e.problem = error.what();
  }
}

}  // namespace

std::string name_of(Alignment alignment) {
  switch (alignment) {
    case Alignment::none:
      return "none";
    case Alignment::first_pose:
      return "first-pose";
    case Alignment::se2:
      return "se2";
    case Alignment::se3:
      return "se3";
    case Alignment::sim3:
      return "sim3";
  }
  throw std::invalid_argument("unknown alignment");
}

Eigen::Isometry3d map_place(const EvaluatedEstimate& e, Alignment alignment) {
  const Eigen::Isometry3d& T_aligned = e.report->alignment.T_truth_estimate;
  const bool other_body = e.body && !e.body_aligned;  // its orientations are not the truth's
  if (alignment != Alignment::se3 || other_body) return T_aligned;
  return placed_by_poses(e.report->matches) * T_aligned;
}

std::string name_of(Association association) {
  return association == Association::nearest ? "nearest" : "interpolate";
}

Evaluation evaluate_all(EvaluationInputs inputs, const EvaluationSettings& settings, bool find_clock_offset,
                        const ClockOffsetSearch& search, bool align_bodies) {
  Evaluation evaluation{std::move(inputs.truth), {}, std::move(inputs.notes), settings};
  for (EvaluatedPath& path : inputs.estimates) {
    EvaluatedEstimate e;
    e.path = std::move(path);
    evaluate_one(e, evaluation.truth.trajectory, settings, align_bodies);
    if (e.report && find_clock_offset) find_clock(e, evaluation.truth.trajectory, settings, search);
    evaluation.estimates.push_back(std::move(e));
  }
  return evaluation;
}

std::string format_evaluation(const Evaluation& evaluation) {
  std::string text;
  for (const EvaluatedEstimate& e : evaluation.estimates)
    if (!e.path.truth_origin.empty())
      text += fmt::format("MADE FROM GROUND TRUTH, its errors prove nothing: {} ({})\n", e.path.name,
                          e.path.truth_origin);
  const EvaluatedPath& truth = evaluation.truth;
  const double seconds =
      1e-6 * static_cast<double>(truth.trajectory.back().utime - truth.trajectory.front().utime);
  text += fmt::format("truth: {}{}, {} poses, {:.1f} s, {:.2f} m\n", truth.file,
                      truth.channel.empty() ? "" : ":" + truth.channel, truth.trajectory.size(), seconds,
                      path_length(truth.trajectory));
  const EvaluationSettings& s = evaluation.settings;
  const std::string reach =
      s.association == Association::nearest
          ? fmt::format("at most {:g} s apart", s.max_time_difference)
          : fmt::format("the truth's gaps of at most {:g} s", 10 * s.max_time_difference);
  text += fmt::format("alignment {}, association {} ({}), clock offset {} s\n", name_of(s.alignment),
                      name_of(s.association), reach, s.clock_offset);
  for (const std::string& note : evaluation.notes) text += note + "\n";
  text += "\n" + error_table(evaluation).text() + "\n";
  for (const EvaluatedEstimate& e : evaluation.estimates) {
    if (e.body) text += body_text(e);
    if (e.report) text += turn_text(e, s.alignment);
    if (e.report && e.report->consistency) text += consistency_text(e);
    if (e.clock) text += clock_text(e);
    if (!e.problem.empty()) text += e.path.name + ": " + e.problem + "\n";
  }
  return text;
}

EvaluationPlot evaluation_plot(const Evaluation& evaluation) {
  EvaluationPlot plot;
  const Trajectory& truth = evaluation.truth.trajectory;
  plot.paths.push_back(top_view("truth", plot_colour(0), truth));
  const Eigen::Vector2d gap = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (const EvaluatedEstimate& e : evaluation.estimates) {
    if (!e.report) continue;
    const auto colour = plot_colour(1 + (plot.paths.size() - 1) % 6);  // the truth's colour is its own
    PlottedPath path{e.path.name, colour, {}}, error{e.path.name, colour, {}};
    Utime last = 0;
    for (const MatchedPose& match : e.report->matches) {
      const bool lost_track =
          !path.points.empty() && static_cast<double>(match.utime - last) > 1e6 * e.report->tracking_gap;
      if (lost_track) path.points.push_back(gap), error.points.push_back(gap);
      last = match.utime;
      path.points.emplace_back(match.T_world_estimate.translation().head<2>());
      error.points.emplace_back(
          1e-6 * static_cast<double>(match.utime - truth.front().utime),
          (match.T_world_estimate.translation() - match.T_world_truth.translation()).norm());
    }
    plot.paths.push_back(std::move(path));
    plot.errors.push_back(std::move(error));
  }
  return plot;
}

}  // namespace lcmslam

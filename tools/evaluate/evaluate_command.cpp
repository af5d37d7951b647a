#include <fmt/format.h>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include <lcmslam/evaluation/surface_error.hpp>
#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/evaluation/wall_error.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/simulation/scene.hpp>
#include "tools/commands.hpp"
#include "tools/evaluate/dense_map_log.hpp"
#include "tools/evaluate/evaluation_report.hpp"
#include "tools/evaluate/export_poses.hpp"
#include "tools/evaluate/reference_surface.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

const std::map<std::string, Alignment> alignments = {{"se3", Alignment::se3},
                                                     {"sim3", Alignment::sim3},
                                                     {"first-pose", Alignment::first_pose},
                                                     {"se2", Alignment::se2},
                                                     {"none", Alignment::none}};
const std::map<std::string, Association> associations = {{"nearest", Association::nearest},
                                                         {"interpolate", Association::interpolate_truth}};

template <class T>
CLI::IsMember one_of(const std::map<std::string, T>& choices) {
  std::vector<std::string> names;
  names.reserve(choices.size());
  for (const auto& [name, value] : choices) names.push_back(name);
  return CLI::IsMember(names);
}

struct Request {
  InputRequest inputs;
  std::string alignment = "se3", association, json;
  std::vector<std::string> plots;
  std::string map, scene, reference, walls;
  EvaluationSettings settings;
  bool find_clock_offset = false, align_bodies = false, kitti = false;
  std::string exported;
  ClockOffsetSearch search;
};

std::optional<int> parse(Request& r, int argc, char** argv) {
  CLI::App app{
      "Compares estimated trajectories with the truth: absolute (ATE) and relative (RPE) errors as the TUM "
      "RGB-D benchmark's paper defines them (its script differs a little: E of an RPE is turned around, the "
      "distance "
      "of a metre is the estimate's). FILE is a text file (TUM: t x y z qx qy qz qw; EuRoC's or KITTI's) or "
      "an "
      ".lcmlog, also "
      "LOG:CHANNEL; a log alone stands for its FASTSLAM_POSE, ICP_POSE, ICP_FINAL (its path as its last "
      "graph "
      "has it) and ODOMETRY, and brings its "
      "GROUND_TRUTH.",
      "lcmslam evaluate"};
  app.add_option("--truth", r.inputs.truth, "FILE or LOG[:CHANNEL]");
  app.add_option("estimate,--estimate", r.inputs.estimates, "FILE or LOG[:CHANNEL], one or more");
  app.add_option("--alignment", r.alignment, "taken away before errors are measured (se3)")
      ->check(one_of(alignments));
  app.add_option(
         "--association", r.association,
         "nearest stamps (TUM's; default when the truth is a text file), or the truth interpolated at "
         "the estimate's stamps (default when it is a log)")
      ->check(one_of(associations));
  app.add_option(
         "--max-difference", r.settings.max_time_difference,
         "s, between matched stamps; the truth is interpolated over gaps up to 10 times as long (0.02)")
      ->check(CLI::Range(1e-6, 1e3));
  auto* offset =
      app.add_option("--clock-offset", r.settings.clock_offset,
                     "s, added to the stamps of the estimates and of --reference's images, unless its log is "
                     "the truth's and no estimate's")
          ->check(CLI::Range(-1e9, 1e9));
  app.add_flag("--estimate-clock-offset", r.find_clock_offset,
               "find the offset with the least ATE and show the errors without and with it")
      ->excludes(offset);
  app.add_option("--clock-range", r.search.range, "s, largest offset that is looked for (0.5)")
      ->check(CLI::Range(0.01, 10.0));
  const CLI::IsMember bodies({"robot", "camera"});
  app.add_option("--truth-frame", r.inputs.truth_body, "whose pose the truth is, where it does not say so")
      ->check(bodies);
  app.add_option("--estimate-frame", r.inputs.estimate_body, "the same for the estimates")->check(bodies);
  app.add_option(
         "--calibration", r.inputs.calibration,
         "LOG or FILE.yaml that says where the camera sits on the robot (default: a log that is read)")
      ->check(CLI::ExistingFile);
  app.add_flag("--align-bodies", r.align_bodies,
               "take away a constant rotation and lever between truth and estimate too: of errors from 8 "
               "degrees and 3 cm on, of NEES whatever fits best");
  auto* exported = app.add_option("--export", r.exported,
                                  "write the one estimate's poses into this file (TUM's format, with the "
                                  "frames in its first line) and end; no truth is needed");
  app.add_flag("--kitti", r.kitti, "--export in KITTI's format, stamps in FILE_times.txt beside it")
      ->needs(exported);
  app.add_option("--plot", r.plots, "FILE.png or FILE.svg: paths from above, errors over time")
      ->check(CLI::Validator(
          [](const std::string& name) {
            const std::string end = std::filesystem::path(name).extension();
            return end == ".png" || end == ".svg" ? "" : name + " must end in .png or .svg";
          },
          "FILE.png|FILE.svg"));
  auto* map = app.add_option("--map", r.map,
                             "FILE.ply: how far its points are from the surfaces of --scene or --reference; "
                             "brought to the truth's world by the alignment of the last estimate, and by its "
                             "orientations where a straight path leaves the turn about it open");
  auto* scene = app.add_option("--scene", r.scene, "FILE.yaml of the simulation")->needs(map);
  app.add_option(
         "--reference", r.reference,
         "LOG whose depth images, fused at the true poses, are the surfaces (tangent planes, 1 cm apart)")
      ->needs(map)
      ->excludes(scene);
  app.add_option(
      "--walls", r.walls,
      "FILE.yaml of the simulation: do its walls stand where they stood on the first visit, in the "
      "dense map (ICP_KEYFRAME) of the last estimate's log? Walls more than 0.15 m off are only counted");
  app.add_option("--json", r.json, "file for all figures");
  if (const auto exit_code = parse_command(app, argc, argv)) return exit_code;
  if (!r.inputs.truth.empty() || !r.inputs.estimates.empty() || !r.exported.empty()) return std::nullopt;
  std::cerr << "lcmslam evaluate: no truth: give --truth FILE and what to compare with it, or a log that has "
               "both\nRun with --help for more information.\n";
  return 2;
}

SurfaceError scene_error(const Request& r, const Eigen::Isometry3d& T_truth_map) {
  std::vector<Triangle> triangles;
  for (const SceneTriangle& t : load_scene(r.scene).triangles)
    triangles.push_back({t.corner[0], t.corner[1], t.corner[2]});
  return surface_error(load_ply(r.map).points, T_truth_map, TriangleSurface(std::move(triangles)));
}

bool are_one_file(const std::string& a, const std::string& b) {
  std::error_code none;
  return a == b || std::filesystem::equivalent(a, b, none);
}

/// Of the images of --reference, s. They were taken by the clock of what was estimated from them; of a log
/// that tells the truth alone nobody says so.
double reference_clock_offset(const Request& r, const EvaluatedPath& truth, const EvaluatedPath& estimate) {
  const bool of_truth = are_one_file(r.reference, truth.file) && !are_one_file(r.reference, estimate.file);
  return of_truth ? 0 : r.settings.clock_offset;
}

SurfaceError reference_error(const Request& r, const EvaluatedPath& truth, double clock_offset,
                             const Eigen::Isometry3d& T_truth_map, int& refused) {
  constexpr float reach = 0.3f;  // m
  const ReferenceSurface surface(r.reference, truth.trajectory, truth.body == "camera", clock_offset);
  refused = surface.refused();
  return surface_error(
      load_ply(r.map).points, T_truth_map,
      [&](const Eigen::Vector3f& p) { return surface.distance(p, reach); }, reach);
}

/// The last estimate of a map. `option`: who asks.
const EvaluatedEstimate& map_estimate(const std::string& option, const Evaluation& evaluation) {
  const EvaluatedEstimate* placed = nullptr;
  for (const EvaluatedEstimate& e : evaluation.estimates)
    if (e.report && e.path.channel != "ODOMETRY") placed = &e;
  if (placed == nullptr) throw std::runtime_error(option + ": no estimate says where the map lies");
  return *placed;
}

std::string metres(double value) {
  return fixed_number(value, 4);
}

/// As text and for --json.
struct Figures {
  std::string text;
  nlohmann::json json;
};

Figures wall_figures(const Request& r, const Evaluation& evaluation) {
  const EvaluatedEstimate& placed = map_estimate("--walls", evaluation);
  std::vector<WallTriangle> walls;
  std::vector<Triangle> others;
  for (const SceneTriangle& t : load_scene(r.walls).triangles) {
    const Triangle corners = {t.corner[0], t.corner[1], t.corner[2]};
    if (t.kind == SurfaceKind::wall)
      walls.push_back({corners, t.normal[0]});
    else
      others.push_back(corners);
  }
  const LoggedDenseMap map = dense_map_of(placed.path.file, map_place(placed, evaluation.settings.alignment));
  const WallErrorSettings settings;
  const WallError e = wall_error(map.points, walls, TriangleSurface(std::move(others)), settings);
  Figures figures;
  figures.text = fmt::format(
      "\n{}: walls of {} in patches of 0.25 m, placed by {}: {} seen again after 20 s or more, where first "
      "and last visit lie apart by {} m (median), {} m (95 %), {} m (largest); {} patches, thickness {} m "
      "(median), {} m (95 %); {} % of {} points are more than {} m from any surface: a wall that far off is "
      "in no patch and no offset\n",
      placed.path.file, r.walls, placed.path.name, e.revisited, metres(e.offset_median), metres(e.offset_p95),
      metres(e.offset_max), e.patches, metres(e.thickness_median), metres(e.thickness_p95),
      fixed_number(100 * e.beyond, 2), e.points, settings.reach);
  if (map.refused > 0)
    figures.text += fmt::format("{}: {} messages of the map could not be decoded or were refused\n",
                                placed.path.file, map.refused);
  figures.json = {{"file", placed.path.file},
                  {"placed_by", placed.path.name},
                  {"scene", r.walls},
                  {"points", map.points.size()},
                  {"refused_messages", map.refused},
                  {"reach_m", settings.reach},
                  {"beyond_share", e.beyond},
                  {"patches", e.patches},
                  {"thickness_median_m", e.thickness_median},
                  {"thickness_p95_m", e.thickness_p95},
                  {"revisited_patches", e.revisited},
                  {"offset_median_m", e.offset_median},
                  {"offset_p95_m", e.offset_p95},
                  {"offset_max_m", e.offset_max}};
  return figures;
}

Figures map_figures(const Request& r, const Evaluation& evaluation) {
  const EvaluatedEstimate& placed = map_estimate("--map", evaluation);
  const Eigen::Isometry3d T = map_place(placed, evaluation.settings.alignment);
  int refused = 0;  // messages of the reference
  const double clock_offset = reference_clock_offset(r, evaluation.truth, placed.path);
  const SurfaceError e = r.reference.empty() ? scene_error(r, T)
                                             : reference_error(r, evaluation.truth, clock_offset, T, refused);
  const std::string& surfaces = r.reference.empty() ? r.scene : r.reference;
  Figures figures;
  figures.text = fmt::format(
      "\n{}: {} points, placed by {}; distance to the surfaces of {}: median {} m, 95 % within {} m, "
      "mean {} m, {} % beyond 0.3 m\n",
      r.map, e.points, placed.path.name, surfaces, metres(e.median), metres(e.p95), metres(e.mean),
      fixed_number(100 * e.beyond, 2));
  if (!r.reference.empty() && r.settings.clock_offset != 0)
    figures.text +=
        fmt::format("{}: its images' stamps are taken {}\n", r.reference,
                    clock_offset != 0 ? fmt::format("{:+.4f} s, as the estimates'", clock_offset)
                                      : "as they are, on the truth's clock: it is the truth's log");
  if (refused > 0)
    figures.text += fmt::format("{}: {} messages could not be decoded\n", r.reference, refused);
  figures.json = {{"file", r.map},      {"placed_by", placed.path.name}, {"surfaces", surfaces},
                  {"points", e.points}, {"median_m", e.median},          {"p95_m", e.p95},
                  {"mean_m", e.mean},   {"beyond_share", e.beyond},      {"refused_messages", refused}};
  return figures;
}

}  // namespace

int evaluate_command(int argc, char** argv) {
  Request r;
  if (const auto exit_code = parse(r, argc, argv)) return *exit_code;
  if (!r.map.empty() && r.scene.empty() && r.reference.empty())
    throw std::runtime_error("--map: needs --scene or --reference");
  if (r.alignment == "sim3" && !(r.map.empty() && r.walls.empty()))
    throw std::runtime_error(
        "--map, --walls: --alignment sim3 scales the path and not the map, which lies elsewhere then; use "
        "se3");
  if (!r.exported.empty()) {
    export_poses(r.inputs, r.exported, r.kitti);
    return 0;
  }
  EvaluationInputs inputs = read_inputs(r.inputs);
  r.settings.alignment = alignments.at(r.alignment);
  r.settings.fit_body = r.align_bodies;
  r.settings.association = !r.association.empty()         ? associations.at(r.association)
                           : inputs.truth.channel.empty() ? Association::nearest
                                                          : Association::interpolate_truth;
  const Evaluation evaluation =
      evaluate_all(std::move(inputs), r.settings, r.find_clock_offset, r.search, r.align_bodies);
  std::cout << format_evaluation(evaluation);
  nlohmann::json json = evaluation_json(evaluation);
  const auto add = [&json](const char* name, Figures figures) {
    std::cout << figures.text;
    json[name] = std::move(figures.json);
  };
  if (!r.map.empty()) add("map", map_figures(r, evaluation));
  if (!r.walls.empty()) add("walls", wall_figures(r, evaluation));
  for (const std::string& file : r.plots) write_plot(file, evaluation_plot(evaluation));
  if (!r.json.empty())
    write_atomically(FilePlace(r.json),
                     json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  const bool all = std::all_of(evaluation.estimates.begin(), evaluation.estimates.end(),
                               [](const EvaluatedEstimate& e) { return e.report.has_value(); });
  return all ? 0 : 1;
}

}  // namespace lcmslam

#include "procs/icp/read_settings.hpp"

#include <algorithm>

#include <lcmslam/configuration/named_choice.hpp>

namespace lcmslam {
namespace {

const Range metres{0, 1000};
const Range radians{0, 3.1416};
const Range share{0, 1};

RegistrationSettings read_registration(const ConfigNode& c, RegistrationSettings s) {
  s.selection = named_choice<SelectionKind>(c, "selection", s.selection,
                                            {{"all", SelectionKind::all},
                                             {"uniform", SelectionKind::uniform},
                                             {"random", SelectionKind::random},
                                             {"normal_space", SelectionKind::normal_space},
                                             {"stable", SelectionKind::stable}});
  s.selected_points = c.get("selected_points", s.selected_points, Range{10, 1e7});
  s.seed = static_cast<std::uint64_t>(c.get("seed", static_cast<int>(s.seed), Range{0, 1e9}));
  s.metric = named_choice<MetricKind>(c, "metric", s.metric,
                                      {{"point_to_point", MetricKind::point_to_point},
                                       {"point_to_plane", MetricKind::point_to_plane},
                                       {"plane_to_plane", MetricKind::plane_to_plane}});
  s.solver = named_choice<SolverKind>(c, "solver", s.solver,
                                      {{"svd", SolverKind::svd},
                                       {"svd_uncorrected", SolverKind::svd_uncorrected},
                                       {"quaternion", SolverKind::quaternion},
                                       {"quaternion_as_printed", SolverKind::quaternion_as_printed},
                                       {"small_angle", SolverKind::small_angle},
                                       {"small_angle_as_printed", SolverKind::small_angle_as_printed},
                                       {"gauss_newton", SolverKind::gauss_newton},
                                       {"levenberg_marquardt", SolverKind::levenberg_marquardt}});
  s.kernel = named_choice<KernelKind>(c, "kernel", s.kernel,
                                      {{"none", KernelKind::none},
                                       {"huber", KernelKind::huber},
                                       {"geman_mcclure", KernelKind::geman_mcclure}});
  s.kernel_width = c.get("kernel_width", s.kernel_width, Range{0.01, 1e6});
  s.max_distance = c.get("max_distance", s.max_distance, metres);
  s.min_distance = c.get("min_distance", s.min_distance, metres);
  s.distance_sigmas = c.get("distance_sigmas", s.distance_sigmas, Range{0, 1e6});
  s.max_normal_angle = c.get("max_normal_angle", s.max_normal_angle, radians);
  s.trimmed_fraction = c.get("trimmed_fraction", s.trimmed_fraction, share);
  s.mutual = c.get("mutual", s.mutual);
  s.boundary = c.get("boundary", s.boundary);
  s.weigh_by_noise = c.get("weigh_by_noise", s.weigh_by_noise);
  s.noise_floor = c.get("noise_floor", s.noise_floor, metres);
  s.max_iterations = c.get("max_iterations", s.max_iterations, Range{1, 10000});
  s.epsilon_translation = c.get("epsilon_translation", s.epsilon_translation, metres);
  s.epsilon_rotation = c.get("epsilon_rotation", s.epsilon_rotation, radians);
  s.degenerate_share = c.get("degenerate_share", s.degenerate_share, share);
  s.independent_pairs = c.get("independent_pairs", s.independent_pairs, Range{1, 1e9});
  s.min_pairs = c.get("min_pairs", s.min_pairs, Range{1, 1e6});
  return s;
}

/// Of the mapper's passes, which compare views and colours, too.
RegistrationSettings read_pass(const ConfigNode& c, const RegistrationSettings& fallback,
                               CorrespondenceKind correspondence) {
  RegistrationSettings s = read_registration(c, fallback);
  s.epsilon_rms = c.get("epsilon_rms", s.epsilon_rms, metres);
  s.frustum = c.get("frustum", s.frustum);
  s.colour_overlap = c.get("colour_overlap", s.colour_overlap);
  s.colour_scale = c.get("colour_scale", s.colour_scale, metres);
  if (s.boundary && correspondence == CorrespondenceKind::voxel_map)
    c.fail("boundary",
           "the voxel map knows no boundaries; icp.correspondence may be kd_tree, projective or "
           "normal_shooting");
  if (!is_iterative(s.solver) && (s.metric != MetricKind::point_to_point || s.colour_scale > 0))
    c.fail("solver",
           "a closed form minimises point_to_point without colour alone; others need gauss_newton or "
           "levenberg_marquardt");
  return s;
}

AlternatingSettings read_icp(const ConfigNode& c, AlternatingSettings s) {
  s.registration = read_registration(c.section("registration"), s.registration);
  s.cloud_iterations = c.get("cloud_iterations", s.cloud_iterations, Range{1, 1000});
  s.feature_iterations = c.get("feature_iterations", s.feature_iterations, Range{1, 1000});
  s.pairing = named_choice<FeaturePairing>(
      c, "pairing", s.pairing, {{"nearest", FeaturePairing::nearest}, {"fixed", FeaturePairing::fixed}});
  s.max_rounds = c.get("max_rounds", s.max_rounds, Range{1, 10000});
  s.epsilon_rms = c.get("epsilon_rms", s.epsilon_rms, metres);
  return s;
}

ColourOverlapSettings read_overlap(const ConfigNode& c, ColourOverlapSettings s) {
  s.columns = c.get("columns", s.columns, Range{1, 1000});
  s.rows = c.get("rows", s.rows, Range{1, 1000});
  s.scale = c.get("scale", s.scale, Range{0.01, 1});
  s.threshold = c.get("threshold", s.threshold, Range{-1, 1});
  s.min_contrast = c.get("min_contrast", s.min_contrast, Range{0, 255});
  s.search = c.get("search", s.search, Range{0, 10000});
  return s;
}

ThesisSettings read_thesis(const ConfigNode& c, ThesisSettings s) {
  s.icp = read_icp(c, s.icp);
  s.overlap = read_overlap(c.section("overlap"), s.overlap);
  s.checked_features = c.get("checked_features", s.checked_features);
  s.merge_distance = c.get("merge_distance", s.merge_distance, metres);
  return s;
}

}  // namespace

DenseMapperSettings read_icp_settings(const ConfigNode& c) {
  DenseMapperSettings s;
  s.voxel_size = c.get("voxel_size", s.voxel_size, Range{0.001, 10});
  s.correspondence =
      named_choice<CorrespondenceKind>(c, "correspondence", s.correspondence,
                                       {{"voxel_map", CorrespondenceKind::voxel_map},
                                        {"kd_tree", CorrespondenceKind::kd_tree},
                                        {"projective", CorrespondenceKind::projective},
                                        {"normal_shooting", CorrespondenceKind::normal_shooting}});
  s.view_radius = c.get("view_radius", s.view_radius, Range{0.1, 1000});
  s.coarse = read_pass(c.section("coarse"), s.coarse, s.correspondence);
  s.fine = read_pass(c.section("fine"), s.fine, s.correspondence);
  s.overlap = read_overlap(c.section("overlap"), s.overlap);

  s.variant = named_choice<VariantKind>(c, "variant", s.variant,
                                        {{"modern", VariantKind::modern},
                                         {"plain", VariantKind::plain},
                                         {"alternating", VariantKind::alternating},
                                         {"frustum", VariantKind::frustum}});
  s.thesis = read_thesis(c.section("thesis"), s.thesis);

  const ConfigNode filter = c.section("filter");
  s.filter.min_range = filter.get("min_range", s.filter.min_range, metres);
  s.filter.max_range = filter.get("max_range", s.filter.max_range, metres);
  s.filter.max_incidence = filter.get("max_incidence", s.filter.max_incidence, radians);
  s.filter.max_sigma = filter.get("max_sigma", s.filter.max_sigma, metres);

  const ConfigNode map = c.section("map");
  s.map.voxel_size = map.get("voxel_size", s.map.voxel_size, Range{0.001, 10});
  s.map.max_blocks = map.get("max_blocks", s.map.max_blocks, Range{100, 1e8});
  s.map.max_evidence = map.get("max_evidence", s.map.max_evidence, Range{1, 100});
  s.map.miss = map.get("miss", s.map.miss, Range{1, 100});
  s.map.dropped_at = map.get("dropped_at", s.map.dropped_at, Range{-100, -1});

  const ConfigNode free_space = c.section("free_space");
  s.free_space.enabled = free_space.get("enabled", s.free_space.enabled);
  s.free_space.sigmas = free_space.get("sigmas", s.free_space.sigmas, Range{0, 1000});
  s.free_space.tolerance = free_space.get("tolerance", s.free_space.tolerance, metres);
  s.free_space.lateral = free_space.get("lateral", s.free_space.lateral, metres);
  s.free_space.rotation = free_space.get("rotation", s.free_space.rotation, Range{1, 100});

  const ConfigNode features = c.section("features");
  s.features.enabled = features.get("enabled", s.features.enabled);
  s.features.keyframes = features.get("keyframes", s.features.keyframes, Range{1, 20});
  s.features.max_distance = features.get("max_distance", s.features.max_distance, metres);
  s.features.max_angle = features.get("max_angle", s.features.max_angle, radians);
  s.features.min_inliers = features.get("min_inliers", s.features.min_inliers, Range{3, 1000});
  s.features.searched_keyframes =
      features.get("searched_keyframes", s.features.searched_keyframes, Range{0, 1000});
  s.features.floor_translation = features.get("floor_translation", s.features.floor_translation, metres);
  s.features.floor_rotation = features.get("floor_rotation", s.features.floor_rotation, radians);
  s.features.max_disagreement = features.get("max_disagreement", s.features.max_disagreement, Range{0, 1e6});

  const ConfigNode clock = c.section("depth_clock");
  s.depth_clock.enabled = clock.get("enabled", s.depth_clock.enabled);
  s.depth_clock.prior = clock.get("prior", s.depth_clock.prior, Range{1e-4, 1});
  s.depth_clock.noise = clock.get("noise", s.depth_clock.noise, Range{1e-4, 1});
  s.depth_clock.outlier = clock.get("outlier", s.depth_clock.outlier, radians);

  const ConfigNode graph = c.section("graph");
  s.graph.enabled = graph.get("enabled", s.graph.enabled);
  s.graph.neighbours = graph.get("neighbours", s.graph.neighbours, Range{0, 100});
  s.graph.max_distance = graph.get("max_distance", s.graph.max_distance, metres);
  s.graph.max_angle = graph.get("max_angle", s.graph.max_angle, radians);
  s.graph.floor_translation = graph.get("floor_translation", s.graph.floor_translation, metres);
  s.graph.floor_rotation = graph.get("floor_rotation", s.graph.floor_rotation, radians);
  s.graph.min_translation = graph.get("min_translation", s.graph.min_translation, metres);
  s.graph.min_rotation = graph.get("min_rotation", s.graph.min_rotation, radians);
  s.graph.wait = graph.get("wait", s.graph.wait, Range{0, 10});
  s.graph.time = graph.get("time", s.graph.time, Range{0, 100});
  s.graph.max_keyframes = c.get("max_keyframes", s.graph.max_keyframes, Range{20, 1e6});
  s.graph.max_waiting = graph.get("max_waiting", s.graph.max_waiting, Range{0, 1e6});
  s.graph.time_per_node = graph.get("time_per_node", s.graph.time_per_node, Range{0, 1});
  const ConfigNode optimiser = graph.section("optimiser");
  s.graph.optimiser.kernel_width =
      optimiser.get("kernel_width", s.graph.optimiser.kernel_width, Range{0.1, 1e6});
  s.graph.optimiser.max_error = optimiser.get("max_error", s.graph.optimiser.max_error, Range{0.1, 1e6});
  s.graph.optimiser.path_gate = optimiser.get("path_gate", s.graph.optimiser.path_gate, Range{0, 1e6});
  s.graph.optimiser.loop_support =
      optimiser.get("loop_support", s.graph.optimiser.loop_support, Range{1, 100});
  const ConfigNode loops = graph.section("loops");
  s.graph.loops.indexed_features =
      loops.get("indexed_features", s.graph.loops.indexed_features, Range{10, 10000});
  s.graph.loops.min_votes = loops.get("min_votes", s.graph.loops.min_votes, Range{1, 10000});
  s.graph.loops.candidates = loops.get("candidates", s.graph.loops.candidates, Range{0, 100});
  s.graph.loops.min_inliers = loops.get("min_inliers", s.graph.loops.min_inliers, Range{3, 1000});
  s.graph.loops.min_overlap = loops.get("min_overlap", s.graph.loops.min_overlap, share);
  s.graph.loops.min_inlier_share = loops.get("min_inlier_share", s.graph.loops.min_inlier_share, share);
  s.graph.loops.floor_translation = loops.get("floor_translation", s.graph.loops.floor_translation, metres);
  s.graph.loops.floor_rotation = loops.get("floor_rotation", s.graph.loops.floor_rotation, radians);
  s.graph.loops.registration = read_registration(loops.section("registration"), s.graph.loops.registration);

  const ConfigNode prior = c.section("prior");
  s.prior.floor_translation = prior.get("floor_translation", s.prior.floor_translation, metres);
  s.prior.floor_rotation = prior.get("floor_rotation", s.prior.floor_rotation, radians);
  s.prior.free_translation = prior.get("free_translation", s.prior.free_translation, metres);
  s.prior.free_rotation = prior.get("free_rotation", s.prior.free_rotation, radians);

  s.lost_overlap = c.get("lost_overlap", s.lost_overlap, share);
  s.good_overlap = c.get("good_overlap", s.good_overlap, share);
  s.insert_distance = c.get("insert_distance", s.insert_distance, metres);
  s.insert_angle = c.get("insert_angle", s.insert_angle, radians);
  s.keyframe_distance = c.get("keyframe_distance", s.keyframe_distance, metres);
  s.keyframe_angle = c.get("keyframe_angle", s.keyframe_angle, radians);
  s.keyframe_overlap = c.get("keyframe_overlap", s.keyframe_overlap, share);
  s.keyframe_voxel = c.get("keyframe_voxel", s.keyframe_voxel, Range{0.001, 10});
  s.keyframe_features = c.get("keyframe_features", s.keyframe_features, Range{20, 100000});
  s.keyframe_points = c.get("keyframe_points", s.keyframe_points, Range{1000, 1e10});
  return s;
}

DepthFilterSettings read_depth_filter_settings(const ConfigNode& c) {
  DepthFilterSettings s;
  s.parts = c.get("parts", s.parts);
  const auto& known = depth_filter_parts();
  for (const std::string& part : s.parts)
    if (std::find(known.begin(), known.end(), part) == known.end())
      c.fail("parts", "'" + part + "' is none of amplitude, jump_edges, speckle, bilateral");

  const ConfigNode amplitude = c.section("amplitude");
  s.amplitude.min_amplitude = amplitude.get("min_amplitude", s.amplitude.min_amplitude, share);
  const ConfigNode jump_edges = c.section("jump_edges");
  s.jump_edges.noise_sigmas = jump_edges.get("noise_sigmas", s.jump_edges.noise_sigmas, Range{0, 1000});
  s.jump_edges.free_incidence = jump_edges.get("free_incidence", s.jump_edges.free_incidence, Range{0, 1.57});
  s.jump_edges.max_incidence = jump_edges.get("max_incidence", s.jump_edges.max_incidence, Range{0, 1.57});
  const ConfigNode speckle = c.section("speckle");
  s.speckle.min_solid_angle = speckle.get("min_solid_angle", s.speckle.min_solid_angle, Range{0, 1});
  const ConfigNode bilateral = c.section("bilateral");
  s.bilateral.range_sigmas = bilateral.get("range_sigmas", s.bilateral.range_sigmas, Range{0.1, 1000});
  return s;
}

}  // namespace lcmslam

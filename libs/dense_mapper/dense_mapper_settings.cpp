#include <lcmslam/dense_mapper/dense_mapper_settings.hpp>

namespace lcmslam {

RegistrationSettings DenseMapperSettings::coarse_defaults() {
  RegistrationSettings s;
  s.selection = SelectionKind::uniform;
  s.selected_points = 400;
  s.max_distance = 0.25;
  s.min_distance = 0.12;
  s.max_normal_angle = 0.8;
  s.max_iterations = 8;
  s.epsilon_translation = 4e-3;
  s.epsilon_rotation = 2e-3;
  return s;
}

RegistrationSettings DenseMapperSettings::fine_defaults() {
  RegistrationSettings s;
  s.selection = SelectionKind::uniform;
  s.selected_points = 3000;
  s.max_distance = 0.10;
  s.min_distance = 0.06;
  s.max_iterations = 10;
  return s;
}

void DenseMapperSettings::describe(SettingsVisitor& s) {
  s.choice(
      "variant", variant, variant_names,
      "modern, or what the thesis registers with instead of both passes (algorithms 3.1, 3.2, section 3.5)");
  s.number("voxel_size", voxel_size, "m", {0, 10},
           "of the cloud that is registered and inserted; 0: all of its points");
  s.choice("correspondence", correspondence, correspondence_names, "how the passes find partners in the map");
  s.number("view_radius", view_radius, "m", {0.1, 1000},
           "of the map around the camera that k-d trees and projections show");
  s.section("coarse", coarse, "first pass of registration: few points from far",
            &RegistrationSettings::describe_pass);
  s.section("fine", fine, "second pass of registration", &RegistrationSettings::describe_pass);
  s.section("overlap", overlap, "of the passes' colour_overlap");
  for (auto* pass : {&coarse, &fine})
    s.require(
        !pass->boundary || correspondence != CorrespondenceKind::voxel_map,
        pass == &coarse ? "coarse.boundary" : "fine.boundary",
        "must be false: the voxel map knows no boundaries; correspondence may be kd_tree, projective or "
        "normal_shooting");
  s.section("thesis", thesis, "the variants of the thesis");
  s.require(
      variant != VariantKind::alternating || thesis.icp.registration.metric == MetricKind::point_to_point,
      "thesis.registration.metric", "must be point_to_point for the variant alternating");

  s.section("filter", filter, "which measured points may enter registration and map");
  s.section("map", map, "the growing map that frames are registered to");
  s.section("free_space", free_space, "what is not there any more");
  s.section("features", features, "where the SURF features of a frame place the robot");
  s.section("mount_error", mount_error,
            "what the told covariance of a pose holds for the head's place on the robot");
  s.number("stamp_sigma", stamp_sigma, "s", {0, 1},
           "of all images' stamps alike: how far the robot moves meanwhile is part of a pose's covariance");
  s.section("depth_clock", depth_clock, "by how much the depth image's stamps are off");
  s.section("graph", graph, "the keyframes' pose graph");
  s.section("prior", prior, "what is known before a frame is registered");
  s.section("ground", prior.ground, "the plane that a robot on wheels is said to drive on");

  s.number("min_points", min_points, "", {1, 1e6},
           "usable points after the voxel filter; fewer are no basis");
  s.number("lost_overlap", lost_overlap, "", {0, 1}, "overlap with the map below which the robot is lost");
  s.number("good_overlap", good_overlap, "", {0, 1},
           "overlap below which tracking is degraded, and which a recovery must reach");
  s.number("good_inliers", good_inliers, "", {0, 1},
           "share of the pairs within three sigmas, below which tracking is degraded");
  s.number("max_jump", max_jump, "m", {0, 1000}, "beyond the prediction: lost");
  s.number("max_turn", max_turn, "rad", {0, 3.1416}, "beyond the prediction: lost");
  s.number("max_disagreement", max_disagreement, "", {0, 1e6},
           "standard deviations from where the wheels have led, beyond which a frame that no features place "
           "fits another place: lost");
  s.number(
      "reseed_after", reseed_after, "", {1, 1e6},
      "bad frames after which odometry, if there is any, is believed where the map does not contradict it");
  s.number(
      "carried_after", carried_after, "s", {0, 1e6},
      "of frames that show another place than the map has where the wheels say the robot is; then it was "
      "carried: it is looked for in the whole map, and maps nothing until it is found; 0: never");
  s.number("recovery_keyframes", recovery_keyframes, "", {0, 1000},
           "tried as starts in each frame while lost, without wheels");

  s.number("insert_distance", insert_distance, "m", {0, 1000}, "between insertions into the map");
  s.number("insert_angle", insert_angle, "rad", {0, 3.1416}, "between insertions into the map");
  s.number("keyframe_distance", keyframe_distance, "m", {0, 1000}, "between keyframes");
  s.number("keyframe_angle", keyframe_angle, "rad", {0, 3.1416}, "between keyframes");
  s.number("keyframe_overlap", keyframe_overlap, "", {0, 1},
           "a keyframe is also due when less of the view is known than this");
  s.number("keyframe_voxel", keyframe_voxel, "m", {0.001, 10}, "of a keyframe's cloud");
  s.number("keyframe_features", keyframe_features, "", {20, 100000}, "strongest of a keyframe that are kept");
  s.number("keyframe_points", keyframe_points, "", {1000, 1e10},
           "of all keyframes together (31 bytes each: 190 MB); beyond, the farthest clouds are thinned");
  s.number("max_keyframes", graph.max_keyframes, "", {5, 1e6},
           "that are kept, and other nodes of the graph: 50, or as many as keyframes; a tenth goes at a time "
           "(0.25 MB each)");
  s.number("deform_time", deform_time, "s", {0, 10},
           "of message time that deforming the map takes, besides deform_time_per_surfel");
  s.number("deform_time_per_surfel", deform_time_per_surfel, "s", {0, 1},
           "of message time that deforming the map takes for each surfel, besides deform_time");
}

}  // namespace lcmslam

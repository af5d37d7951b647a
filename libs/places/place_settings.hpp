#pragma once
#include <lcmslam/registration/registration_settings.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct PlaceSettings {
  int indexed_features = 300;
  double max_descriptor_distance = 0.35;
  int min_votes = 6;
  int candidates = 8;
  double map_sigma = 0.01;
  int min_inliers = 14;
  double min_margin = 2;
  double same_place_distance = 0.5;
  double same_place_angle = 0.5;
  double min_spread = 0.08;
  int visits = 4;
  double same_view_distance = 0.15;
  double same_view_angle = 0.15;
  double cloud_voxel = 0.04;
  int pooled_views = 8;
  double min_overlap = 0.3;
  double min_inlier_share = 0.6;
  double max_disagreement = 3;
  double tolerance_translation = 0.02;
  double tolerance_rotation = 0.02;
  double max_seen_through = 0.15;
  double min_agreement = 0.6;
  double surface_pairs = 10;
  double floor_translation = 0.005;
  double floor_rotation = 0.003;
  RegistrationSettings registration = registration_defaults();

  static RegistrationSettings registration_defaults() {
    RegistrationSettings s;
    s.selection = SelectionKind::uniform;
    s.selected_points = 1500;
    s.max_distance = 0.15;
    s.min_distance = 0.06;
    s.max_iterations = 15;
    return s;
  }

  void describe(SettingsVisitor& s) {
    s.number("indexed_features", indexed_features, "", {10, 10000},
             "strongest of each keyframe, and of who asks, by which a place is found");
    s.number("max_descriptor_distance", max_descriptor_distance, "", {0, 2},
             "between descriptors of unit norm; nearer ones vote");
    s.number("min_votes", min_votes, "", {1, 10000}, "that make a keyframe a candidate");
    s.number("candidates", candidates, "", {1, 100}, "most voted keyframes whose features are matched");
    s.number("map_sigma", map_sigma, "m", {0, 1},
             "by which keyframes of one map lie beside each other, added (squared) to a point's covariance");
    s.number("min_inliers", min_inliers, "", {3, 10000}, "features that one pose must explain");
    s.number("min_margin", min_margin, "", {1, 100},
             "times as many as any other place explains: else places look alike");
    s.number("same_place_distance", same_place_distance, "m", {0, 100}, "nearer poses are no other place");
    s.number("same_place_angle", same_place_angle, "rad", {0, 3.1416},
             "poses turned by less, and as near, are no other place");
    s.number("min_spread", min_spread, "", {0, 0.5},
             "of those features in the image along its shorter direction, as a share of its width: one "
             "poster is no place");
    s.number("visits", visits, "", {1, 1000},
             "keyframes that stand at one place and look one way: of more, made by one session after the "
             "other, the first and the last stay");
    s.number("same_view_distance", same_view_distance, "m", {0, 100}, "between those");
    s.number("same_view_angle", same_view_angle, "rad", {0, 3.1416}, "between those");
    s.number("cloud_voxel", cloud_voxel, "m", {0.005, 1}, "between points that keyframes are kept with");
    s.number("pooled_views", pooled_views, "", {1, 100},
             "nearest keyframes that the asker's cloud is registered to");
    s.number("min_overlap", min_overlap, "", {0, 1}, "of the clouds, after registration");
    s.number("min_inlier_share", min_inlier_share, "", {0, 1}, "of the pairs, within three sigmas");
    s.number("max_disagreement", max_disagreement, "", {0, 1e6},
             "Mahalanobis distance between what the clouds and what the features say");
    s.number("tolerance_translation", tolerance_translation, "m", {0, 1},
             "by which those may differ, added (squared): colour and depth of a camera that moves are of two "
             "moments");
    s.number("tolerance_rotation", tolerance_rotation, "rad", {0, 1}, "the same for the rotation");
    s.number("max_seen_through", max_seen_through, "", {0, 1},
             "share of the view in which the asker sees through surfaces of the map");
    s.number("min_agreement", min_agreement, "", {0, 1},
             "share of the view in which the map's surfaces are as far as the asker's");
    s.number("surface_pairs", surface_pairs, "", {1, 1e9},
             "for as many surfaces count where they and the features decide together: both clouds bear the "
             "errors of one camera, which no number of points takes away");
    s.number("floor_translation", floor_translation, "m", {0, 1000},
             "noise floor of a found pose, added (squared)");
    s.number("floor_rotation", floor_rotation, "rad", {0, 3.1416},
             "noise floor of a found pose, added (squared)");
    s.section("registration", registration, "of the asker's cloud");
  }
};

}  // namespace lcmslam

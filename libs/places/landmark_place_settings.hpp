#pragma once
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct LandmarkPlaceSettings {
  double max_descriptor_distance = 0.35;
  double position_sigma = 0.03;
  int visits = 2;
  double same_landmark = 0.05;
  int min_inliers = 12;
  double min_margin = 2;
  double min_spread = 0.25;
  double near_a_landmark = 0.3;
  double min_share = 0.15;
  double same_place_distance = 0.15;
  double same_place_angle = 0.15;
  double floor_translation = 0.01;
  double floor_rotation = 0.005;

  void describe(SettingsVisitor& s) {
    s.number("max_descriptor_distance", max_descriptor_distance, "", {0, 2},
             "between descriptors of unit norm; farther landmarks do not look alike");
    s.number("position_sigma", position_sigma, "m", {0, 10},
             "at most of one landmark beside its neighbours, however far the map as a whole may be off");
    s.number("visits", visits, "", {1, 3},
             "sessions that a landmark is kept of: what so many have mapped already is left out");
    s.number("same_landmark", same_landmark, "m", {0.001, 10},
             "between landmarks that are the same if they look alike");
    s.number("min_inliers", min_inliers, "", {3, 10000}, "landmarks of the group that one pose must explain");
    s.number("min_margin", min_margin, "", {1, 100},
             "times as many as any other place explains: else places look alike");
    s.number("min_spread", min_spread, "m", {0, 100},
             "of those along their second direction: one poster is no place");
    s.number("near_a_landmark", near_a_landmark, "m", {0, 100},
             "who lies as near to one of the map's is where the map was looked at");
    s.number("min_share", min_share, "", {0, 1}, "of the group's landmarks there that must be in the map");
    s.number("same_place_distance", same_place_distance, "m", {0, 100}, "nearer poses are no other place");
    s.number("same_place_angle", same_place_angle, "rad", {0, 3.1416},
             "poses turned by less, and as near, are no other place");
    s.number("floor_translation", floor_translation, "m", {0, 1000},
             "noise floor of a found pose, added (squared)");
    s.number("floor_rotation", floor_rotation, "rad", {0, 3.1416},
             "noise floor of a found pose, added (squared)");
  }
};

}  // namespace lcmslam

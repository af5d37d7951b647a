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

}  // namespace lcmslam

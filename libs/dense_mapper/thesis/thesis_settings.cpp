#include <lcmslam/dense_mapper/thesis/thesis_settings.hpp>

namespace lcmslam {

std::string to_string(VariantKind kind) {
  static const char* const names[] = {"modern", "plain", "alternating", "frustum"};
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace lcmslam

#include <lcmslam/dense_mapper/tracker.hpp>

#include <lcmslam/dense_mapper/modern_tracker.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_tracker.hpp>

namespace lcmslam {

std::string to_string(MappingStatus status) {
  switch (status) {
    case MappingStatus::initialising:
      return "initialising";
    case MappingStatus::tracking:
      return "tracking";
    case MappingStatus::degraded:
      return "degraded";
    case MappingStatus::lost:
      return "lost";
  }
  return "unknown";
}

std::unique_ptr<Tracker> make_tracker(const DenseMapperSettings& settings, DeformableMap& map,
                                      const KeyframeStore& keyframes) {
  if (settings.variant == VariantKind::modern)
    return std::make_unique<ModernTracker>(settings, map, keyframes);
  return std::make_unique<ThesisTracker>(settings.variant, settings.thesis);
}

double inlier_share(const RegistrationResult& r) {
  return r.pairs > 0 ? static_cast<double>(r.inliers) / r.pairs : 0;
}

}  // namespace lcmslam

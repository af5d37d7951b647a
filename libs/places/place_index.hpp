#pragma once
// Where in a map was this seen? Keyframes that look alike (SURF) are found by votes; one pose must explain
// the matched points of all of them (RANSAC), explain far more of them than any other place does, agree with
// the registration of the clouds, and the asker must not see through surfaces of the map. A wrong answer is
// worse than none.
//
//   PlaceIndex places;
//   places.add(key, T_map_camera, features, cloud);   // each keyframe
//   const Located here = places.locate(features, cloud);
//   here.place ? use(here.place->T_map_camera, here.place->covariance) : say(here.why_not);

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/places/place_settings.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

/// What speaks for a place, as far as it was looked at.
struct PlaceEvidence {
  std::vector<std::int64_t> keyframes;  ///< whose features agree, by key
  int inliers = 0;                      ///< features of the asker that the pose explains
  int other_inliers = 0;                ///< that the best other place explains
  double rms = 0;                       ///< m, between clouds after registration
  double overlap = 0;                   ///< of the asker's cloud with the map's, 0..1
  double inlier_share = 0;              ///< of the clouds' pairs, within three sigmas
  double agrees = 0;                    ///< share of the view in which both are as far, 0..1
  double seen_through = 0;              ///< share of the view in which it contradicts the map, 0..1
};

struct Place {
  Eigen::Isometry3d T_map_camera = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_map_camera, right perturbation
};

struct Located {
  std::optional<Place> place;
  std::string why_not;  ///< empty where there is a place
  PlaceEvidence evidence;
};

/// In words, for people.
std::string to_string(const PlaceEvidence& evidence);

class PlaceIndex {
 public:
  /// Throws std::invalid_argument that names the setting.
  explicit PlaceIndex(const PlaceSettings& settings = {});

  /// A keyframe: features (their points) and cloud are in the camera's frame. One that is there already is
  /// replaced. Features without a point are left out. Where a place was mapped again and again (`visits`),
  /// one between the first and the last goes: the first hold the map's frame, the last show how it looks now.
  void add(std::int64_t key, const Eigen::Isometry3d& T_map_camera, const FeatureFrame& features,
           const ColouredCloud& cloud);
  /// Keyframes that are not there are left out.
  void move(std::int64_t key, const Eigen::Isometry3d& T_map_camera);
  void drop(std::int64_t key);
  /// Adds the keyframes of another map, which lies there in this one, under their keys plus `first_key`.
  void take_over(const PlaceIndex& other, const Eigen::Isometry3d& T_map_other, std::int64_t first_key);
  bool has(std::int64_t key) const { return views_.count(key) > 0; }
  /// From `first` to before `end`.
  std::vector<std::int64_t> keys(std::int64_t first, std::int64_t end) const;
  std::size_t size() const { return views_.size(); }
  std::size_t memory_bytes() const;

  /// Where these were seen. Without a cloud the features' points must do.
  Located locate(const FeatureFrame& features, const ColouredCloud& cloud = {});
  /// What another map, which lies there in this one, has found for these features: no place any more where
  /// this one has another place that looks alike.
  void look_for_twin(const FeatureFrame& features, const Eigen::Isometry3d& T_this_other, Located& located);

 private:
  struct View {
    Eigen::Isometry3d T_map_camera;
    FeatureFrame features;
    Cloud cloud;              // reduced, camera frame
    std::vector<int> slots;   // ids in the index
    std::int64_t number = 0;  // in the order in which they were added
  };
  struct Pairs {
    std::vector<PointPair> points;   // a: map, b: asker
    std::vector<int> feature;        // of the asker
    std::vector<std::int64_t> view;  // key
  };

  void add(std::int64_t key, View view);
  void thin_around(const Eigen::Isometry3d& T_map_camera);
  std::string search(const FeatureFrame& asker, const ColouredCloud& cloud, Located& located);
  std::string explain(const FeatureFrame& asker, const Pairs& pairs, PlaceEvidence& evidence,
                      UncertainTransform& pose) const;
  std::string look_elsewhere(const FeatureFrame& asker, const std::vector<std::int64_t>& keys,
                             const Eigen::Isometry3d& T_map_camera, PlaceEvidence& evidence);
  std::string fit_surfaces(const FeatureFrame& asker, const Cloud& seen, const UncertainTransform& pose,
                           Located& located) const;
  std::vector<std::int64_t> most_voted(const FeatureFrame& asker, const std::vector<bool>& without = {});
  std::vector<std::int64_t> most_voted_elsewhere(const FeatureFrame& asker,
                                                 const Eigen::Isometry3d& T_map_camera);
  Pairs match(const FeatureFrame& asker, const std::vector<std::int64_t>& keys);
  Cloud pool(const Eigen::Isometry3d& T_map_camera) const;

  PlaceSettings settings_;
  std::map<std::int64_t, View> views_;
  std::int64_t added_ = 0;
  DescriptorIndex index_;
  std::vector<std::int64_t> key_of_slot_;
  std::vector<int> free_slots_;
  DescriptorSearch search_;
  Matcher matcher_;
};

}  // namespace lcmslam

#pragma once
// Where in a map of landmarks does a group of landmarks of another map lie? As PlaceIndex, without clouds:
// one pose must explain many of those that look alike (SURF, RANSAC), all over the group, far more of them
// than any other place does, and a fair share of all that lie where the map was looked at.

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/features/landmark.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/places/landmark_place_settings.hpp>
#include <lcmslam/places/place_index.hpp>

namespace lcmslam {

/// Where a group of landmarks was found.
struct LocatedGroup {
  Eigen::Isometry3d T_session_group = Eigen::Isometry3d::Identity();  ///< at its middle, axes of its map
  std::optional<Place> place;                                         ///< T_map_camera: of the group
  std::string why_not;                                                ///< empty where there is a place
  int inliers = 0;        ///< landmarks of the group that the pose explains
  int other_inliers = 0;  ///< that the best other place explains
  double share = 0;       ///< found, of those that lie where the map was looked at, 0..1
};

class LandmarkPlaces {
 public:
  /// Throws std::invalid_argument that names the setting.
  explicit LandmarkPlaces(const LandmarkPlaceSettings& settings = {});

  /// Landmarks of a map that lies there. Those without a descriptor (known identities) are left out, and
  /// those that the map has of `visits` sessions already. `session`: by which they may be dropped.
  void add(const std::vector<Landmark>& landmarks,
           const Eigen::Isometry3d& T_map_session = Eigen::Isometry3d::Identity(), std::int64_t session = 0);
  /// All landmarks of a session.
  void drop(std::int64_t session);
  std::size_t size() const { return landmarks_.size(); }
  /// In the map's frame.
  const std::vector<Landmark>& landmarks() const { return landmarks_; }

  LocatedGroup locate(const std::vector<Landmark>& group);
  /// Where LocatedGroup says that a group lies in its own map.
  static Eigen::Isometry3d middle_of(const std::vector<Landmark>& group);

 private:
  struct Pairs {
    std::vector<PointPair> points;     // a: map, b: group
    std::vector<int> landmark, asker;  // index of either
  };
  void insert(const Landmark& landmark, std::int64_t session);
  std::size_t known(const Landmark& landmark, std::size_t before) const;
  Pairs alike(const std::vector<Landmark>& group, const Eigen::Vector3d& middle);
  int other_place(const Pairs& pairs, const Eigen::Isometry3d& T_map_group) const;
  double share_found(const std::vector<Landmark>& group, const Eigen::Isometry3d& T_map_session,
                     int found) const;
  std::string search(const std::vector<Landmark>& group, LocatedGroup& located);

  LandmarkPlaceSettings settings_;
  std::vector<Landmark> landmarks_;
  std::vector<std::int64_t> sessions_;                                 // theirs
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;  // where they stand, by voxel_key
  DescriptorIndex index_;
  DescriptorSearch search_;
};

/// The landmark as another map has it, which lies there in this one.
Landmark transformed(Landmark landmark, const Eigen::Isometry3d& T);

}  // namespace lcmslam

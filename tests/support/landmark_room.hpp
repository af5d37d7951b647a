#pragma once
// A room's landmarks as drives through it map them: some of its things each, in the order in which they come
// into view, with noise. A third of the things look like others elsewhere in the room.

#include <algorithm>
#include <vector>

#include <lcmslam/features/landmark.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam::testing_scene {

class LandmarkRoom {
 public:
  /// `things`: seed of what is there; rooms of the same seed are twins.
  explicit LandmarkRoom(std::uint64_t things) {
    Random random(things, 11);
    std::vector<Descriptor> looks(20);
    for (Descriptor& look : looks) look = any_look(random);
    while (things_.size() < 900) {
      // On the walls and on tables, around the middle of 6 m x 5 m.
      const double angle = 2 * M_PI * static_cast<double>(things_.size()) / 900;
      const double range = random.uniform(1.6, 2.6);
      const Eigen::Vector3d at(3 + range * std::cos(angle), 2.5 + range * std::sin(angle),
                               random.uniform(0.1, 2.2));
      const bool common = random.uniform() < 0.33;
      const Descriptor look = any_look(random);
      things_.push_back({at, common ? looks[static_cast<std::size_t>(random.below(looks.size()))] : look,
                         static_cast<std::int8_t>(random.uniform() < 0.5 ? -1 : 1)});
    }
  }

  /// What a session maps that lies there and sees the things from `from` to `to` (0..1, the way around).
  std::vector<Landmark> mapped(const Eigen::Isometry3d& T_session_room, std::uint64_t drive, double from = 0,
                               double to = 1, double share = 0.6) const {
    Random random(drive, 12);
    std::vector<Landmark> landmarks;
    const auto end = static_cast<std::size_t>(to * static_cast<double>(things_.size()));
    for (auto i = static_cast<std::size_t>(from * static_cast<double>(things_.size())); i < end; ++i) {
      if (random.uniform() > share) continue;
      landmarks.push_back(landmark(things_[i].at, things_[i].look, random));
      Landmark& l = landmarks.back();
      l.mean = T_session_room * l.mean;
      l.laplacian = things_[i].laplacian;
      l.id = (std::int64_t{1} << 31) + static_cast<std::int64_t>(landmarks.size());
    }
    return landmarks;
  }

  static constexpr double sigma = 0.01;  // m, of each coordinate
  /// Of a thing that looks like that.
  static Landmark landmark(const Eigen::Vector3d& at, const Descriptor& look, Random& random) {
    Landmark l;
    for (int k = 0; k < 3; ++k) l.mean[k] = at[k] + sigma * random.normal();
    l.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
    l.observations = 5;
    l.laplacian = 1;
    for (std::size_t k = 0; k < look.size(); ++k)
      l.descriptor[k] = static_cast<std::uint8_t>(look[k] + random.uniform(-4, 4));
    return l;
  }
  static Descriptor any_look(Random& random) {
    Descriptor look;
    for (auto& byte : look) byte = static_cast<std::uint8_t>(20 + 216 * random.uniform());
    return look;
  }

 private:
  struct Thing {
    Eigen::Vector3d at;
    Descriptor look;
    std::int8_t laplacian;
  };
  std::vector<Thing> things_;
};

}  // namespace lcmslam::testing_scene

#pragma once
// Answers to questions (map_query/question.hpp): JSON, or the bytes of a file where the answer is one.

#include <functional>
#include <memory>

#include <lcmslam/features/landmark.hpp>
#include <lcmslam/live_map/live_map.hpp>
#include <lcmslam/map_query/question.hpp>
#include <lcmslam/places/place_index.hpp>

namespace lcmslam {

/// What a question may look at. Whoever asks for clouds or landmarks brings those of the region.
struct AskedMap {
  std::string frame;                    ///< that all of it stands in
  std::int64_t changes = 0;             ///< of what it is derived from
  std::shared_ptr<const LiveMap> live;  ///< null: no frame was seen yet
  ColouredCloud cloud;                  ///< m, map frame, neither thinned nor averaged
  std::vector<Landmark> landmarks;
  std::optional<Eigen::Isometry3d> T_map_robot;  ///< the newest pose

  /// Where something was seen, and the frame in which that is said.
  struct Found {
    Located located;
    std::string frame;
    std::optional<Eigen::Isometry3d> T_robot_camera;  ///< of who saw it
  };
  std::function<Found()> locate;  ///< empty: nobody here knows places
  /// Whether nobody waits for the answer any more; empty: there is no deadline.
  std::function<bool()> is_late;
};

struct Answer {
  std::string content;  ///< "application/json", "model/ply", "model/gltf-binary", "image/x-portable-graymap"
  std::string bytes;
};

/// Throws std::runtime_error when the map has no answer, in words for who asked.
Answer answer(const Question& question, const AskedMap& map);

}  // namespace lcmslam

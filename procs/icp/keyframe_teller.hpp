#pragma once
// ICP_KEYFRAME: a map's keyframes as they come and change, in tiles that wait for their turn, since bursts
// overrun receive buffers. What waits follows the graph until it goes out.

#include <deque>
#include <map>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/runtime/node.hpp>

namespace lcmslam {

class KeyframeTeller {
 public:
  using Keyframe = DenseMapper::Keyframe;
  /// What is told of, and under which frame.
  struct Map {
    DenseMapper& mapper;
    std::string frame;
    Eigen::Isometry3d T_robot_camera;
  };

  explicit KeyframeTeller(Publisher& publisher) : publisher_(publisher) {}

  /// As it is now, under a new revision.
  void tell(const Map& map, const Keyframe& keyframe);
  /// Those that changed notably since they were told, or `all` that changed.
  void tell_changed(const Map& map, bool all);
  /// Every one, for whoever missed something; nothing while others wait, since all are under way then.
  void tell_all(const Map& map);

  /// The graph has moved keyframes, or has given some up.
  void move(const Map& map);
  void drop_the_gone(const Map& map);
  /// The next keyframes are another map's. What waits of this one still goes out.
  void begin_map() { told_.clear(); }

  /// Publishes what is due; until when it can wait, or nothing when nothing waits.
  std::optional<Node::Duration> work();
  void finish();

 private:
  struct Told {
    std::int64_t revision = 0;
    std::size_t points = 0;
  };
  void queue(const Map& map, const Keyframe& keyframe, std::int64_t revision);
  void publish_next();

  Publisher& publisher_;
  std::deque<keyframe_t> tiles_;
  std::map<int, Told> told_;    // by keyframe of this map
  std::int64_t revisions_ = 0;  // over all maps
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace lcmslam

#include "procs/bridge/map_tellers.hpp"

#include <algorithm>
#include <iterator>

#include <lcmslam/messages/map_messages.hpp>

namespace lcmslam {
namespace {

bool same_landmark(const Landmark& a, const Landmark& b) {
  return a.observations == b.observations && a.log_odds == b.log_odds && a.mean == b.mean &&
         a.covariance == b.covariance && a.descriptor == b.descriptor;
}

}  // namespace

void LandmarkTeller::hear(const landmarks_t& message) {
  const std::vector<Landmark> landmarks = landmarks_of(message);
  if (message.sender != sender_ || message.frame != frame_) {  // another map
    *this = LandmarkTeller();
    sender_ = message.sender;
    frame_ = message.frame;
  }
  utime_ = message.utime;
  try {
    if (message.base_revision == 0 && message.n_tiles > 1)
      map_.add_tile({message.map_revision, message.tile, message.n_tiles, landmarks});
    else
      map_.apply({message.map_revision, message.base_revision, landmarks, message.removed});
  } catch (const std::invalid_argument& error) {
    throw DecodeError(error.what());
  }
}

std::optional<landmarks_t> LandmarkTeller::tell(bool whole) {
  if (map_.incomplete() || map_.revision() == 0) return std::nullopt;
  whole = whole || told_revision_ == 0;
  if (!whole && map_.revision() == told_revision_) return std::nullopt;
  landmarks_t message;
  message.utime = utime_;
  message.seq = messages_++;
  message.sender = sender_;
  message.frame = frame_;
  message.map_revision = map_.revision();
  message.base_revision = whole ? 0 : told_revision_;
  message.tile = 0;
  message.n_tiles = 1;
  std::map<std::int64_t, Landmark> now;
  for (const Landmark& landmark : map_.landmarks()) {
    const auto told = told_.find(landmark.id);
    if (whole || told == told_.end() || !same_landmark(told->second, landmark))
      message.landmarks.push_back(to_message(landmark));
    now.emplace_hint(now.end(), landmark.id, landmark);
  }
  if (!whole)
    for (const auto& [id, landmark] : told_)
      if (now.count(id) == 0) message.removed.push_back(id);
  message.n_landmarks = static_cast<std::int32_t>(message.landmarks.size());
  message.n_removed = static_cast<std::int32_t>(message.removed.size());
  told_ = std::move(now);
  told_revision_ = message.map_revision;
  return message;
}

void GraphRelay::hear(const graph_t& message) {
  if (message.sender != sender_ || message.frame != frame_) {
    *this = GraphRelay();
    sender_ = message.sender;
    frame_ = message.frame;
  }
  graph_.apply(message);
  utime_ = message.utime;
  heard_ = changed_ = true;
}

std::optional<graph_t> GraphRelay::tell(bool whole) {
  if (!heard_ || !graph_.complete() || (!changed_ && !(whole && told_))) return std::nullopt;
  graph_t message{};
  message.utime = utime_;
  message.frame = frame_;
  message.map_revision = graph_.map_revision();
  std::set<std::int32_t> nodes;
  for (const auto& [id, node] : graph_.nodes()) {
    message.nodes.push_back(node);
    nodes.insert(id);
  }
  gone_.clear();
  std::set_difference(told_nodes_.begin(), told_nodes_.end(), nodes.begin(), nodes.end(),
                      std::back_inserter(gone_));
  told_nodes_ = std::move(nodes);
  for (const auto& [pair, edge] : graph_.edges()) message.edges.push_back(edge);
  message.n_nodes = static_cast<std::int32_t>(message.nodes.size());
  message.n_edges = static_cast<std::int32_t>(message.edges.size());
  message = teller_.tell(std::move(message), whole);
  message.sender = sender_;
  changed_ = false;
  told_ = true;
  return message;
}

}  // namespace lcmslam

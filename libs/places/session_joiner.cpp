#include <lcmslam/places/session_joiner.hpp>

#include <Eigen/Dense>
#include <algorithm>

#include <lcmslam/pose_graph/pose_graph.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {

std::string to_string(const Joint& joint) {
  return std::to_string(joint.agreeing) + " of " + std::to_string(joint.asked) + " " + joint.what +
         " were found and agree, " + std::to_string(joint.disagreeing) + " say otherwise";
}

SessionJoiner::SessionJoiner(const JoinSettings& settings, std::string what)
    : settings_(settings), what_(std::move(what)) {
  check(settings, "joining of sessions");
}

void SessionJoiner::add(const Eigen::Isometry3d& T_session_camera, const FeatureFrame& features,
                        const ColouredCloud& cloud, PlaceIndex& map, std::int32_t id) {
  if (!knows(T_session_camera)) say(T_session_camera, map.locate(features, cloud).place, id);
}

bool SessionJoiner::knows(const Eigen::Isometry3d& T_session_part) const {
  const auto is_near = [&](const Saying& saying) {
    return distance_between(saying.T_session_part, T_session_part) < settings_.min_distance &&
           angle_between(saying.T_session_part, T_session_part) < settings_.min_angle;
  };
  return std::any_of(sayings_.begin(), sayings_.end(), is_near);
}

SessionJoiner::Saying::Saying(const Place& found, const JoinSettings& settings, std::int32_t number)
    : id(number), T_map_part(found.T_map_camera), part_covariance(found.covariance) {
  part_covariance.diagonal().head<3>().array() += settings.floor_translation * settings.floor_translation;
  part_covariance.diagonal().tail<3>().array() += settings.floor_rotation * settings.floor_rotation;
}

// T_map_session = T_map_part exp(xi) T_part_session: the error moves to the session's frame.
void SessionJoiner::Saying::place(const Eigen::Isometry3d& T) {
  T_session_part = T;
  T_map_session = T_map_part * T.inverse();
  const Matrix6d to_session = adjoint(T);
  covariance = to_session * part_covariance * to_session.transpose();
}

void SessionJoiner::say(const Eigen::Isometry3d& T_session_part, const std::optional<Place>& found,
                        std::int32_t id) {
  ++asked_;
  if (!found) return;
  Saying saying(*found, settings_, id);
  saying.place(T_session_part);
  sayings_.push_back(saying);
  vote();
}

void SessionJoiner::move(const std::map<std::int32_t, Eigen::Isometry3d>& T_session_part) {
  bool any = false;
  for (Saying& saying : sayings_) {
    const auto moved = T_session_part.find(saying.id);
    if (moved == T_session_part.end()) continue;
    saying.place(moved->second);
    any = true;
  }
  if (any) vote();
}

void SessionJoiner::drop(const std::vector<std::int32_t>& ids) {
  const auto is_dropped = [&](const Saying& saying) {
    return std::find(ids.begin(), ids.end(), saying.id) != ids.end();
  };
  const auto left = std::remove_if(sayings_.begin(), sayings_.end(), is_dropped);
  if (left == sayings_.end()) return;
  sayings_.erase(left, sayings_.end());
  vote();
}

bool SessionJoiner::agree(const Saying& a, const Saying& b) const {
  return distance_from_identity({a.T_map_session.inverse() * b.T_map_session, a.covariance + b.covariance}) <=
         settings_.max_disagreement;
}

/// The saying that most agree with counts, with all of those: their mean, weighted by information.
void SessionJoiner::vote() {
  joint_.reset();
  std::vector<const Saying*> best;
  for (const Saying& centre : sayings_) {
    std::vector<const Saying*> agreeing;
    for (const Saying& saying : sayings_)
      if (agree(centre, saying)) agreeing.push_back(&saying);
    if (agreeing.size() > best.size()) best = std::move(agreeing);
  }
  const int agreeing = static_cast<int>(best.size());
  const int disagreeing = static_cast<int>(sayings_.size()) - agreeing;
  if (agreeing < settings_.min_agreeing * (1 + disagreeing)) return;
  Joint joint{best.front()->T_map_session, Matrix6d::Zero(), agreeing, disagreeing, asked_, what_};
  for (int round = 0; round < 3; ++round) {
    Matrix6d information = Matrix6d::Zero();
    Vector6d pull = Vector6d::Zero();
    for (const Saying* saying : best) {
      const Matrix6d weight = saying->covariance.inverse();
      information += weight;
      pull += weight * se3_log(joint.T_map_session.inverse() * saying->T_map_session);
    }
    joint.covariance = information.inverse();
    joint.T_map_session = joint.T_map_session * se3_exp(joint.covariance * pull);
  }
  joint_ = joint;
}

}  // namespace lcmslam

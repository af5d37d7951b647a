#include <lcmslam/map_client/map_client.hpp>

#include <map>
#include <nlohmann/json.hpp>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/options.hpp>

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr auto asked_again_after = std::chrono::seconds(1);  // without a tile
constexpr std::size_t most_tiles = 1 << 20;

Clock::duration seconds(double value) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
}

/// "model/ply; frame=map; map_version=12"
MapClient::Reply described(const std::string& content) {
  MapClient::Reply reply;
  reply.content = content.substr(0, content.find(';'));
  const auto value = [&](const std::string& key) {
    const std::size_t begin = content.find("; " + key + "=");
    if (begin == std::string::npos) return std::string();
    const std::size_t from = begin + key.size() + 3;
    return content.substr(from, content.find(';', from) - from);
  };
  reply.frame = value("frame");
  reply.map_version = std::atoll(value("map_version").c_str());
  return reply;
}

/// The answer's JSON; `read` takes out of it what was asked for.
template <class Read>
auto read_json(const MapClient::Reply& reply, const Read& read) {
  try {
    return read(json::parse(reply.bytes));
  } catch (const json::exception& error) {
    throw MapError(std::string("the map server's answer is not understood: ") + error.what());
  }
}

Eigen::Vector3d vector(const json& row) {
  return {row.at(0).get<double>(), row.at(1).get<double>(), row.at(2).get<double>()};
}

}  // namespace

class MapClient::Bus {
 public:
  explicit Bus(const std::string& lcm_url)
      : url_(lcm_url.empty() ? lcm_url_from_environment() : lcm_url),
        bus_(url_),
        publisher_(bus_.lcm(), draw_sender(), largest_whole_message(url_)) {
    if (!bus_.usable()) throw MapError(url_ + " cannot be used; ./lcmslam doctor says why");
    inputs_.subscribe<map_reply_t>("MAP_REPLY", 4000, [this](const map_reply_t& reply) { hear(reply); });
    receiver_.emplace(bus_, inputs_);
  }

  Reply ask(const std::string& question, double deadline) {
    const auto end = Clock::now() + seconds(deadline);
    begin();
    send(question);
    while (Clock::now() < end || is_coming()) {
      Arrival arrival;
      if (receiver_->take(arrival, std::chrono::milliseconds(20))) arrival.deliver();
      if (failed_) throw MapError(error_);
      if (n_tiles_ > 0 && tiles_.size() == n_tiles_) return joined();
      if (Clock::now() >= end || Clock::now() - last_heard_ <= asked_again_after) continue;
      // A tile was lost; or else nobody may have heard it, or the answer takes its time and is welcome later.
      if (!tiles_.empty()) begin();
      send(question);
    }
    throw MapError("no answer from a map server on " + url_ + " within " + std::to_string(deadline) + " s" +
                   (tiles_.empty() ? "" : "; some of it is missing"));
  }

 private:
  void begin() {
    ++id_;
    tiles_.clear();
    n_tiles_ = 0;
    failed_ = false;
  }

  /// Large answers take longer than anybody wants to wait for the first word of one.
  bool is_coming() const { return !tiles_.empty() && Clock::now() - last_heard_ <= asked_again_after; }

  void send(const std::string& question) {
    map_request_t request{};
    request.utime = 0;
    request.request_id = id_;
    request.kind = map_request_t::QUERY;
    request.argument = question;
    publisher_.publish("MAP_REQUEST", request);
    last_heard_ = Clock::now();
  }

  void hear(const map_reply_t& reply) {
    if (reply.request_id != id_ || reply.n_tiles < 1 || reply.tile < 0 || reply.tile >= reply.n_tiles) return;
    if (static_cast<std::size_t>(reply.n_tiles) > most_tiles) return;
    if (n_tiles_ != 0 && reply.sender != server_) return;  // another server's
    server_ = reply.sender;
    last_heard_ = Clock::now();
    if (reply.status != 0) {
      failed_ = true;
      error_ = printable(reply.message);
      return;
    }
    const auto n_tiles = static_cast<std::size_t>(reply.n_tiles);
    // Who was asked twice may answer twice; an answer is put together of one map's tiles only.
    if (n_tiles != n_tiles_ || reply.content != content_) tiles_.clear();
    n_tiles_ = n_tiles;
    content_ = reply.content;
    tiles_[reply.tile] = std::string(reply.data.begin(), reply.data.end());
  }

  Reply joined() const {
    Reply reply = described(content_);
    for (const auto& [number, bytes] : tiles_) reply.bytes += bytes;
    return reply;
  }

  std::string url_;
  LcmBus bus_;
  LcmPublisher publisher_;
  Inputs inputs_;
  std::optional<Receiver> receiver_;
  std::int64_t id_ = draw_sender();  // other programs ask on the same channel
  std::map<std::int32_t, std::string> tiles_;
  std::size_t n_tiles_ = 0;
  std::int64_t server_ = 0;
  std::string content_, error_;
  bool failed_ = false;
  Clock::time_point last_heard_;
};

MapClient::MapClient(const std::string& lcm_url, double deadline)
    : deadline_(deadline), bus_(std::make_unique<Bus>(lcm_url)) {}

MapClient::~MapClient() = default;

MapClient::Reply MapClient::ask(const Question& question) {
  return bus_->ask(to_json(question), question.deadline);
}

std::vector<MapClient::Distance> MapClient::distances(const Points& points) {
  return read_json(ask({DistanceQuestion{points}, deadline_}), [](const json& answer) {
    std::vector<Distance> distances;
    const json& values = answer.at("distances");
    for (std::size_t i = 0; i < values.size(); ++i)
      distances.push_back({values.at(i).get<double>(), vector(answer.at("gradients").at(i))});
    return distances;
  });
}

std::vector<bool> MapClient::collides(const std::vector<CollisionQuestion::Body>& bodies) {
  const std::vector<std::size_t> order = json_order(bodies);
  return read_json(ask({CollisionQuestion{bodies}, deadline_}), [&](const json& answer) {
    std::vector<bool> collides(bodies.size());
    for (std::size_t i = 0; i < order.size(); ++i)
      collides[order[i]] = answer.at("collides").at(i).get<bool>();
    return collides;
  });
}

std::optional<std::size_t> MapClient::first_collision(const Box& robot,
                                                      const std::vector<Eigen::Isometry3d>& T_map_robot) {
  return read_json(ask({PathQuestion{robot, T_map_robot}, deadline_}), [](const json& answer) {
    std::optional<std::size_t> first;
    if (!answer.at("free").get<bool>()) first = answer.at("first_collision").get<std::size_t>();
    return first;
  });
}

std::vector<MapClient::Space> MapClient::space(const Points& points) {
  return read_json(ask({SpaceQuestion{points}, deadline_}), [](const json& answer) {
    std::vector<Space> states;
    for (const json& state : answer.at("states"))
      states.push_back(state == "free"       ? Space::free
                       : state == "occupied" ? Space::occupied
                                             : Space::unknown);
    return states;
  });
}

std::vector<MapClient::Object> MapClient::objects(const Eigen::Vector3d& near, double radius) {
  ObjectsQuestion question;
  question.planes.near = near;
  question.planes.radius = radius;
  return read_json(ask({question, deadline_}), [](const json& answer) {
    std::vector<Object> objects;
    for (const json& o : answer.at("objects")) {
      const json& q = o.at("quaternion");
      Object object{Eigen::Isometry3d::Identity(), vector(o.at("size"))};
      object.T_map_box.translation() = vector(o.at("centre"));
      object.T_map_box.linear() = Eigen::Quaterniond(q.at(0).get<double>(), q.at(1).get<double>(),
                                                     q.at(2).get<double>(), q.at(3).get<double>())
                                      .normalized()
                                      .toRotationMatrix();
      objects.push_back(object);
    }
    return objects;
  });
}

}  // namespace lcmslam

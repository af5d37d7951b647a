#include <lcmslam/ros/topic_choice.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <sstream>
#include <tuple>

#include <lcmslam/datasets/dataset.hpp>

namespace lcmslam::ros {
namespace {

using Fits = std::function<bool(const TopicFacts&)>;
/// What speaks for a topic, the weightiest first.
using Rank = std::array<int, 4>;
using Ranking = std::function<Rank(const TopicFacts&)>;

bool has_word(const std::string& name, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return name.find(word) != std::string::npos; });
}

// What names usually say; the camera's own colour image before those of detectors, which draw into it.
int colour_score(const std::string& name) {
  return (has_word(name, {"color", "colour", "rgb"}) ? 4 : 0) -
         (has_word(name, {"infra", "/ir/", "_ir"}) ? 6 : 0) -
         (has_word(name, {"debug", "overlay", "result", "detect", "annotated", "theora"}) ? 6 : 0);
}
// Depth that is registered to colour needs no transform between the cameras.
int depth_score(const std::string& name) {
  return (has_word(name, {"registered", "aligned"}) ? 4 : 0) + (has_word(name, {"depth"}) ? 2 : 0);
}
int is_raw(const std::string& name) {
  return has_word(name, {"compressed"}) ? 0 : 1;
}

/// How many names both topics begin with: 1 of "/front/color/image" and "/front/depth/image".
int common_path(const std::string& a, const std::string& b) {
  std::istringstream names_a(a), names_b(b);
  std::string name_a, name_b;
  int common = -1;  // both begin with "/"
  while (std::getline(names_a, name_a, '/') && std::getline(names_b, name_b, '/') && name_a == name_b)
    ++common;
  return common;
}

/// What speaks for it that images are of one camera head (a robot may have several), the weightiest first.
struct Kinship {
  bool one_frame = false;
  int path = 0;
};
Kinship kinship(const TopicFacts& a, const TopicFacts& b) {
  return {!a.frame.empty() && a.frame == b.frame, common_path(a.name, b.name)};
}
bool operator<(const Kinship& a, const Kinship& b) {
  return std::tie(a.one_frame, a.path) < std::tie(b.one_frame, b.path);
}

bool names_truth(const std::string& name) {
  return has_word(name, {"ground_truth", "groundtruth", "/gt", "_gt", "mocap", "vicon"});
}
// Others' maps correct their poses, which jump: no odometry. (rtabmap's odometry is one: no word of its name
// begins so.)
bool speaks_of_maps(const std::string& name) {
  const auto begins = [&](const std::string& word) {
    for (std::size_t at = name.find(word); at != std::string::npos; at = name.find(word, at + 1))
      if (at == 0 || std::isalpha(static_cast<unsigned char>(name[at - 1])) == 0) return true;
    return false;
  };
  return begins("map") || begins("slam") || begins("amcl") || begins("global") || begins("gps");
}
int odometry_score(const std::string& name) {
  return (has_word(name, {"odom"}) ? 4 : 0) + (has_word(name, {"wheel"}) ? 1 : 0);
}

std::string line(const std::string& what, const TopicFacts& topic) {
  std::string text = what + ": " + topic.name + " (" + topic.type;
  if (is_image(topic.type))
    text += ", " + topic.encoding + ", " + std::to_string(topic.size.width) + "x" +
            std::to_string(topic.size.height);
  text += ", " + std::to_string(topic.messages) + (topic.messages == 1 ? " message" : " messages");
  if (!topic.frame.empty()) text += ", of " + topic.frame;
  return text + ")";
}

Fits is_of_kind(ImageKind kind) {
  return [kind](const TopicFacts& topic) { return is_image(topic.type) && topic.kind == kind; };
}

class Chooser {
 public:
  Chooser(const std::vector<TopicFacts>& topics, TopicChoice& choice) : topics_(topics), choice_(choice) {}

  /// Sets `name` to the wanted topic or the best of those that fit, and notes it.
  const TopicFacts* choose(const std::string& what, const std::string& option, const Fits& fits,
                           const Ranking& rank, std::string& name) {
    std::vector<const TopicFacts*> found;
    for (const TopicFacts& topic : topics_)
      if (fits(topic) && topic.messages > 0) found.push_back(&topic);
    std::sort(found.begin(), found.end(), [&](auto* a, auto* b) {
      return std::make_tuple(rank(*b), b->messages, a->name) <
             std::make_tuple(rank(*a), a->messages, b->name);
    });
    if (!name.empty()) {
      const auto wanted = std::find_if(found.begin(), found.end(), [&](auto* t) { return t->name == name; });
      if (wanted == found.end()) refuse(what, option, name);
      std::swap(found.front(), *wanted);
    }
    if (found.empty()) return nullptr;
    const bool was_named = !name.empty();
    name = found.front()->name;
    std::string note = line(what, *found.front());
    for (std::size_t i = 1; i < found.size() && !was_named; ++i)
      note += (i == 1 ? "; --" + option + " would take " : ", ") + found[i]->name;
    choice_.notes.push_back(note);
    return found.front();
  }

  [[noreturn]] void refuse(const std::string& what, const std::string& option,
                           const std::string& name) const {
    const auto there = std::find_if(topics_.begin(), topics_.end(), [&](auto& t) { return t.name == name; });
    if (there == topics_.end())
      throw DatasetError("--" + option + " " + name + ": there is no such topic; there are " + list());
    throw DatasetError("--" + option + " " + name + ": is no " + what +
                       " that can be read: " + line("it", *there));
  }

  std::string list() const {
    std::string text;
    for (const TopicFacts& topic : topics_)
      text += (text.empty() ? "" : ", ") + topic.name + " (" + topic.type +
              (topic.encoding.empty() ? "" : ", " + topic.encoding) + ")";
    return text.empty() ? "none" : text;
  }

 private:
  const std::vector<TopicFacts>& topics_;
  TopicChoice& choice_;
};

/// The CameraInfo beside the images; else one of their frame, if they name one.
void choose_info(Chooser& chooser, const std::string& what, const std::string& option,
                 const TopicFacts& images, std::string& name) {
  const std::string beside = camera_info_beside(images.name);
  const bool is_named = !name.empty();
  const Fits fits = [&](const TopicFacts& topic) {
    const bool is_of_frame = !images.frame.empty() && topic.frame == images.frame;
    return is_camera_info(topic.type) && (is_named || topic.name == beside || is_of_frame);
  };
  chooser.choose(
      what, option, fits, [&](const TopicFacts& topic) { return Rank{topic.name == beside}; }, name);
}

/// "/camera/color/image_raw/compressed" -> "/camera/color"
std::string camera_of(const std::string& image_topic) {
  std::string parent = image_topic;
  const auto cut = [&] { parent.erase(std::min(parent.size(), parent.rfind('/'))); };
  for (const char* transport : {"/compressed", "/compressedDepth"})
    if (const std::string ending = transport;
        parent.size() > ending.size() &&
        parent.compare(parent.size() - ending.size(), ending.size(), ending) == 0) {
      cut();
      break;
    }
  cut();
  return parent;
}

}  // namespace

std::string camera_info_beside(const std::string& image_topic) {
  return camera_of(image_topic) + "/camera_info";
}

std::string clock_offset_beside(const std::string& image_topic) {
  return camera_of(image_topic) + "/clock_offset";
}

TopicChoice choose_topics(const std::vector<TopicFacts>& topics, const Topics& wanted) {
  TopicChoice choice;
  choice.topics = wanted;
  Chooser chooser(topics, choice);
  Topics& chosen = choice.topics;
  const Fits is_depth = is_of_kind(ImageKind::depth);
  const auto rank_of_colour = [&](const TopicFacts& colour) {
    Kinship best;  // so that a camera with depth beside it comes before one without
    for (const TopicFacts& depth : topics)
      if (is_depth(depth) && (wanted.depth.empty() || depth.name == wanted.depth))
        best = std::max(best, kinship(colour, depth));
    return Rank{colour_score(colour.name), best.one_frame, best.path, is_raw(colour.name)};
  };
  const TopicFacts* colour = chooser.choose("colour images", "colour-topic", is_of_kind(ImageKind::colour),
                                            rank_of_colour, chosen.colour);
  const auto rank_of_depth = [&](const TopicFacts& depth) {
    const Kinship kin = colour == nullptr ? Kinship() : kinship(*colour, depth);
    return Rank{kin.one_frame, kin.path, depth_score(depth.name), is_raw(depth.name)};
  };
  const TopicFacts* depth =
      chooser.choose("depth images", "depth-topic", is_depth, rank_of_depth, chosen.depth);
  if (colour == nullptr || depth == nullptr)
    throw DatasetError(std::string("has no topic of ") + (colour == nullptr ? "colour" : "depth") +
                       " images (sensor_msgs/Image or CompressedImage, of depth 16UC1 or 32FC1); there are " +
                       chooser.list());
  choose_info(chooser, "colour camera", "colour-info-topic", *colour, chosen.colour_info);
  choose_info(chooser, "depth camera", "depth-info-topic", *depth, chosen.depth_info);
  chooser.choose(
      "odometry", "odometry-topic",
      [&](const TopicFacts& topic) {
        return is_odometry(topic.type) &&
               (!wanted.odometry.empty() || (!names_truth(topic.name) && !speaks_of_maps(topic.name)));
      },
      [](const TopicFacts& topic) { return Rank{odometry_score(topic.name)}; }, chosen.odometry);
  chooser.choose(
      "true poses", "truth-topic",
      [&](const TopicFacts& topic) {
        return is_pose(topic.type) && (!wanted.truth.empty() || names_truth(topic.name));
      },
      [](const TopicFacts&) { return Rank{}; }, chosen.truth);
  return choice;
}

}  // namespace lcmslam::ros

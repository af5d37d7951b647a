// What the whole map server costs on a long drive: the node with its file, both mappers' maps, places, layers
// and snapshots, in one process and as fast as it goes.
//   lcmslam simulate config/scenes/kitchen.yaml lap.lcmlog --head rgbd --seconds 12
//   lcmslam batch lap.lcmlog --out lap
//   build/release/bin/long_map_drive lap.lcmlog lap/batch.lcmlog [--minutes 60] [--every 3] [--new-ground 0]
// The drive is that lap again and again, later: every third image with its features and poses (10 Hz of 30).
// Keyframes are told in the first lap alone, as a mapper does that knows the place; what its graph corrects
// and what landmarks become is told in each. With --new-ground each lap lies so many metres farther, and all
// of it is new.
// (That moves every keyframe to and fro in each lap, more than a mapper would; with --still none after the
// first.)
// A row for each tenth of the drive: CPU of all threads as a share of one core at the drive's own pace
// (without what this program takes to make messages), longest message, what is held, memory, the file.

#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <thread>

#include <CLI/CLI.hpp>

#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/runtime/inputs.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/bench/cpu_time.hpp"

namespace lcmslam {
namespace {

struct Told {
  Utime logged = 0;
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

/// Nobody listens.
class Silence : public Publisher {
 public:
  Silence() : Publisher(1) {}

 private:
  void send(const std::string&, const std::vector<std::uint8_t>&, Utime) override {}
};

std::vector<Told> read(const std::vector<std::string>& logs) {
  const std::set<std::string> wanted = {"CAMERA",       "CAMERA_CALIBRATION", "FEATURES",
                                        "ICP_POSE",     "ICP_GRAPH",          "FASTSLAM_POSE",
                                        "ICP_KEYFRAME", "FASTSLAM_LANDMARKS"};
  std::vector<Told> all;
  for (const std::string& log : logs) {
    LogReader reader(log);
    while (const auto event = reader.next())
      if (wanted.count(event->channel) > 0) all.push_back({event->timestamp, event->channel, event->data});
  }
  std::stable_sort(all.begin(), all.end(), [](const Told& a, const Told& b) { return a.logged < b.logged; });
  return all;
}

double resident_mb() {
  std::ifstream pages("/proc/self/statm");
  double whole = 0, resident = 0;
  pages >> whole >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double file_mb(const std::filesystem::path& file) {
  double bytes = 0;
  for (const char* ending : {"", "-wal"}) {
    std::error_code none;
    const auto size = std::filesystem::file_size(file.string() + ending, none);
    if (!none) bytes += static_cast<double>(size);
  }
  return 1e-6 * bytes;
}

struct Options {
  std::string log, results, folder = "/tmp/long_map_drive";
  double minutes = 60, new_ground = 0;
  int every = 3;
  bool still = false;
};

class Lap {
 public:
  explicit Lap(const Options& options) : options_(options), all_(read({options.log, options.results})) {
    for (const Told& told : all_) {
      if (told.channel == "ICP_KEYFRAME") keyframes_ = std::max(keyframes_, decoded<keyframe_t>(told).id + 1);
      if (told.channel == "FASTSLAM_LANDMARKS") {
        const auto message = decoded<landmarks_t>(told);
        revisions_ = std::max(revisions_, message.map_revision);
        for (const landmark_t& l : message.landmarks) landmarks_ = std::max(landmarks_, l.id - first_id + 1);
      }
      if (told.channel == "CAMERA") ++images_;
    }
  }
  Utime duration() const { return all_.back().logged - all_.front().logged + 33'000; }
  int images() const { return images_ / options_.every; }

  /// Calls `use(channel, bytes)` with each message of the lap of this number.
  template <class Use>
  void tell(int number, const Use& use) {
    number_ = number;
    later_ = number * duration();
    std::map<std::string, int> counts;
    for (const Told& told : all_) {
      const bool of_a_frame = told.channel != "ICP_KEYFRAME" && told.channel != "ICP_GRAPH" &&
                              told.channel != "FASTSLAM_LANDMARKS" && told.channel != "CAMERA_CALIBRATION";
      if (of_a_frame && counts[told.channel]++ % options_.every != 0) continue;
      const std::vector<std::uint8_t> bytes = moved(told);
      if (!bytes.empty()) use(told.channel, bytes);
    }
  }

 private:
  static constexpr std::int64_t first_id = std::int64_t{1} << 31;

  template <class M>
  static M decoded(const Told& told) {
    return decode_message<M>(told.bytes.data(), told.bytes.size());
  }
  bool is_new() const { return options_.new_ground != 0; }
  void move(rigid_transform_t& T) const { T.trans[0] += number_ * options_.new_ground; }

  std::vector<std::uint8_t> moved(const Told& told) {
    if (told.channel == "CAMERA") {
      auto m = decoded<images_t>(told);
      m.utime += later_;
      for (auto& image : m.images) image.utime += later_;
      set_origin(m, {++seq_[told.channel], 11});
      return encode_message(m);
    }
    if (told.channel == "CAMERA_CALIBRATION") return later<camera_calibration_t>(told);
    if (told.channel == "FEATURES") return later<features_t>(told);
    if (told.channel == "ICP_POSE" || told.channel == "FASTSLAM_POSE")
      return later<pose_estimate_t>(told, [&](pose_estimate_t& m) { move(m.T_map_robot); });
    if (told.channel == "ICP_KEYFRAME") {
      if (number_ > 0 && !is_new()) return {};
      return later<keyframe_t>(told, [&](keyframe_t& m) {
        m.id += first_keyframe();
        move(m.T_map_camera);
      });
    }
    if (told.channel == "ICP_GRAPH" && number_ > 0 && options_.still) return {};
    if (told.channel == "ICP_GRAPH") return later<graph_t>(told, [&](graph_t& m) { continue_graph(m); });
    return later<landmarks_t>(told, [&](landmarks_t& m) { continue_landmarks(m); });
  }
  template <class M, class Change>
  std::vector<std::uint8_t> later(const Told& told, const Change& change) {
    M m = decoded<M>(told);
    m.utime += later_;
    m.seq = ++seq_[told.channel];
    change(m);
    return encode_message(m);
  }
  template <class M>
  std::vector<std::uint8_t> later(const Told& told) {
    return later<M>(told, [](M&) {});
  }
  std::int32_t first_keyframe() const { return is_new() ? number_ * keyframes_ : 0; }
  void continue_graph(graph_t& m) const {
    if (number_ > 0) m.change = 1;
    for (graph_node_t& node : m.nodes) {
      node.keyframe += first_keyframe();
      node.keyframe_utime += is_new() ? later_ : 0;
      move(node.T_map_camera);
    }
    for (graph_edge_t& edge : m.edges) {
      edge.from_node += first_keyframe();
      edge.to_node += first_keyframe();
    }
    for (auto* ids : {&m.gone, &m.cut_from, &m.cut_to})
      for (std::int32_t& id : *ids) id += first_keyframe();
  }
  void continue_landmarks(landmarks_t& m) const {
    const std::int64_t more = is_new() ? number_ * landmarks_ : 0;
    if (number_ > 0) m.base_revision += number_ * revisions_;
    m.map_revision += number_ * revisions_;
    for (landmark_t& l : m.landmarks) {
      l.id += more;
      l.mean[0] += number_ * options_.new_ground;
    }
    for (std::int64_t& id : m.removed) id += more;
  }

  Options options_;
  std::vector<Told> all_;
  std::map<std::string, std::int64_t> seq_;
  std::int32_t keyframes_ = 0;
  std::int64_t revisions_ = 0, landmarks_ = 0;
  int images_ = 0, number_ = 0;
  Utime later_ = 0;
};

class Drive {
 public:
  explicit Drive(const Options& options) : options_(options), lap_(options) {
    std::filesystem::remove_all(options.folder);
    MapServerSettings settings;
    settings.folder = options.folder;
    settings.layers.map.background = false;
    settings.snapshot_period = 0;  // of the wall's clock; asked for below at the drive's
    node_ = std::make_unique<MapServerNode>(settings, silence_);
    node_->connect(inputs_);
  }

  void run() {
    const auto laps =
        static_cast<int>(std::lround(6e7 * options_.minutes / static_cast<double>(lap_.duration())));
    std::printf("%d laps of %.1f s, %d images each; %.0f MB resident before\n", laps,
                1e-6 * static_cast<double>(lap_.duration()), lap_.images(), resident_mb());
    begin_row();
    for (int lap = 0; lap < laps; ++lap) {
      double before = cpu_milliseconds();
      lap_.tell(lap, [&](const std::string& channel, const std::vector<std::uint8_t>& bytes) {
        const double made = cpu_milliseconds();
        preparing_ += made - before;
        inputs_.deliver(channel, bytes.data(), bytes.size());
        node_->work();
        before = cpu_milliseconds();
        longest_ = std::max(longest_, before - made);
      });
      for (double s = 0; s < 1e-6 * static_cast<double>(lap_.duration()); ++s) node_->report();
      seconds_ += 1e-6 * static_cast<double>(lap_.duration());
      if (seconds_ >= next_snapshot_) snapshot();
      if ((lap + 1) * 10 / laps != lap * 10 / laps) row();
    }
    const double begin = cpu_milliseconds();
    node_->finish();
    std::printf("its end: %.1f s of CPU, file %.0f MB\n", 1e-3 * (cpu_milliseconds() - begin),
                file_mb(options_.folder + "/map.lcmslam"));
  }

 private:
  double value(const std::string& name) const {
    for (const auto& [key, value] : node_->report().values)
      if (key == name) return value;
    return std::nan("");
  }
  /// As the node does by itself every 20 s, or 50 times as long as it takes; waited for.
  void snapshot() {
    const auto begin = std::chrono::steady_clock::now();
    const double saved = value("saved");
    command_t command;
    command.name = "save";
    node_->command(command);
    for (int i = 0; i < 10'000 && value("saved") <= saved; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      node_->work();
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    next_snapshot_ = seconds_ + std::max(20.0, 50 * took.count());
  }
  void begin_row() {
    begun_ = cpu_milliseconds(CLOCK_PROCESS_CPUTIME_ID);
    preparing_ = longest_ = 0;
    row_seconds_ = seconds_;
  }
  void row() {
    const double cpu = cpu_milliseconds(CLOCK_PROCESS_CPUTIME_ID) - begun_ - preparing_;
    std::printf(
        "%5.1f min: %4.1f %% of a core (longest message %4.0f ms), %5.0f keyframes, %6.0f landmarks, layers "
        "%4.0f "
        "MB, resident %4.0f MB, file %4.0f MB\n",
        seconds_ / 60, 0.1 * cpu / (seconds_ - row_seconds_), longest_, value("keyframes"),
        value("landmarks"), value("layer_memory_mb"), resident_mb(),
        file_mb(options_.folder + "/map.lcmslam"));
    std::fflush(stdout);
    begin_row();
  }

  Options options_;
  Lap lap_;
  Silence silence_;
  Inputs inputs_;
  std::unique_ptr<MapServerNode> node_;
  double seconds_ = 0, row_seconds_ = 0, next_snapshot_ = 20;
  double begun_ = 0, preparing_ = 0, longest_ = 0;  // ms
};

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  lcmslam::Options options;
  CLI::App app("What the whole map server costs on a long drive");
  app.add_option("log", options.log, "one lap's images")->required()->check(CLI::ExistingFile);
  app.add_option("results", options.results, "batch.lcmlog that was made of it")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--minutes", options.minutes, "of the drive")->check(CLI::Range(0.2, 10'000.0));
  app.add_option("--every", options.every, "image of the log is one of the drive's")
      ->check(CLI::Range(1, 100));
  app.add_flag("--still", options.still, "the graph corrects nothing after the first lap");
  app.add_option("--new-ground", options.new_ground,
                 "m by which each lap lies farther than the last; 0: the same");
  app.add_option("--folder", options.folder, "that takes the map, made anew");
  CLI11_PARSE(app, argc, argv);
  try {
    lcmslam::Drive(options).run();
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

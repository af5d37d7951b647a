#include "tools/batch/batch_graph.hpp"

#include <algorithm>
#include <atomic>
#include <future>
#include <map>
#include <stdexcept>

#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/status_reporter.hpp>

#include "procs/fastslam/fastslam_node.hpp"
#include "procs/icp/icp_node.hpp"
#include "procs/map-server/map_server_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tools/process_channels.hpp"

namespace lcmslam {
namespace {

template <class N>
std::unique_ptr<Node> make(const ConfigNode& config, Publisher& publisher) {
  return std::make_unique<N>(config, publisher);
}

using Make = std::unique_ptr<Node> (*)(const ConfigNode&, Publisher&);

const std::map<std::string, Make>& kinds() {
  static const std::map<std::string, Make> all = {{"surf", make<SurfNode>},
                                                  {"odometry", make<OdometryNode>},
                                                  {"fastslam", make<FastSlamNode>},
                                                  {"icp", make<IcpNode>},
                                                  {"map-server", make<MapServerNode>}};
  return all;
}

/// Keeps what a node publishes, with the number of the wave's message that it answers.
class Outbox : public Publisher {
 public:
  using Publisher::Publisher;
  std::size_t cause = 0;
  std::vector<std::pair<std::size_t, BatchMessage>> messages;

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override {
    messages.emplace_back(cause, BatchMessage{channel, bytes, utime});
  }
};

}  // namespace

struct BatchGraph::Member {
  Member(std::string process, std::int64_t sender) : name(std::move(process)), outbox(sender) {}

  bool wants(const BatchMessage& message) const {
    return message.channel == "COMMAND" ||
           std::any_of(inputs.all().begin(), inputs.all().end(),
                       [&](const auto& i) { return i->channel() == message.channel; });
  }

  void handle(const std::vector<BatchMessage>& wave) {
    const double begin = thread_cpu_seconds();
    for (outbox.cause = 0; outbox.cause < wave.size(); ++outbox.cause) {
      const BatchMessage& message = wave[outbox.cause];
      if (!wants(message)) continue;
      inputs.deliver(message.channel, message.bytes.data(), message.bytes.size());
      node->work();
    }
    cpu_seconds += thread_cpu_seconds() - begin;
  }

  std::string name;
  Outbox outbox;
  Inputs inputs;
  std::unique_ptr<Node> node;
  double cpu_seconds = 0;
};

BatchGraph::BatchGraph(const ConfigNode& config, const std::vector<std::string>& processes, int threads,
                       Sink sink)
    : threads_(static_cast<std::size_t>(std::max(1, threads))), sink_(std::move(sink)) {
  for (const std::string& name : processes) {
    const auto kind = kinds().find(name);
    if (kind == kinds().end()) throw std::invalid_argument("batch cannot run the process '" + name + "'");
    // Numbers instead of the random ones of live processes: the same on every run.
    members_.push_back(std::make_unique<Member>(name, static_cast<std::int64_t>(members_.size()) + 1));
    Member& member = *members_.back();
    member.node = kind->second(config.section(name), member.outbox);
    member.node->connect(member.inputs);
    member.inputs.subscribe<command_t>("COMMAND", 100, [&member](const command_t& command) {
      if (command.target.empty() || command.target == member.name) member.node->command(command);
    });
  }
}

BatchGraph::~BatchGraph() = default;

bool BatchGraph::is_input(const std::string& channel) const {
  return !is_told(channel) && std::none_of(members_.begin(), members_.end(),
                                           [&](const auto& member) { return makes(member->name, channel); });
}

void BatchGraph::deliver(BatchMessage message) {
  std::vector<BatchMessage> wave;
  wave.push_back(std::move(message));
  work_off(std::move(wave));
}

void BatchGraph::finish() {
  for (const auto& member : members_) {
    member->outbox.cause = 0;
    member->node->finish();
    work_off(collect(1));
  }
}

void BatchGraph::work_off(std::vector<BatchMessage> wave) {
  while (!wave.empty()) {
    handle(wave);
    wave = collect(wave.size());
  }
}

void BatchGraph::handle(const std::vector<BatchMessage>& wave) {
  std::vector<Member*> busy;
  for (const auto& member : members_)
    if (std::any_of(wave.begin(), wave.end(), [&](const auto& m) { return member->wants(m); }))
      busy.push_back(member.get());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < busy.size(); i = next++) busy[i]->handle(wave);
  };
  std::vector<std::future<void>> helpers;
  for (std::size_t i = 1; i < std::min(threads_, busy.size()); ++i)
    helpers.push_back(std::async(std::launch::async, work));
  work();
  for (auto& helper : helpers) helper.get();
}

std::vector<BatchMessage> BatchGraph::collect(std::size_t causes) {
  std::vector<BatchMessage> published;
  std::vector<std::size_t> taken(members_.size(), 0);
  for (std::size_t cause = 0; cause < causes; ++cause)
    for (std::size_t i = 0; i < members_.size(); ++i) {
      auto& messages = members_[i]->outbox.messages;
      for (; taken[i] < messages.size() && messages[taken[i]].first == cause; ++taken[i])
        published.push_back(std::move(messages[taken[i]].second));
    }
  for (const auto& member : members_) member->outbox.messages.clear();
  for (const BatchMessage& message : published) sink_(message);
  return published;
}

std::vector<BatchGraph::Summary> BatchGraph::summary() const {
  std::vector<Summary> all;
  for (const auto& member : members_) {
    Summary summary;
    summary.process = member->name;
    summary.cpu_seconds = member->cpu_seconds;
    for (const auto& input : member->inputs.all()) {
      summary.decode_errors += input->decode_errors;
      if (input->decode_errors > 0)
        summary.refused[input->channel()] = {input->decode_errors, input->last_error};
      summary.received += input->senders.total().received;
    }
    for (const auto& [channel, count] : member->outbox.counts()) summary.published += count.sent;
    summary.report = with_stamps(member->node->report(), member->inputs.stamps());
    all.push_back(std::move(summary));
  }
  return all;
}

}  // namespace lcmslam

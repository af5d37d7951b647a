#include <lcmslam/runtime/process.hpp>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <iostream>

#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/confirmation.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/processor_watch.hpp>
#include <lcmslam/runtime/status_pace.hpp>
#include <lcmslam/runtime/status_reporter.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include <lcmslam/runtime/terminal_colours.hpp>
#include <lcmslam/runtime/version.hpp>

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds longest_wait{100};  // a stop request is seen within this time
constexpr std::chrono::milliseconds look_period{50};    // a node that has changed its state says so within it
constexpr std::chrono::seconds longest_drain{2};        // of what still arrives when a stop is asked
constexpr unsigned longest_stop = 60;                   // s, above a supervisor's own patience

class Process {
 public:
  Process(std::string name, LcmBus& bus, std::size_t largest_whole)
      : name_(std::move(name)),
        bus_(bus),
        publisher_(bus.lcm(), draw_sender(), largest_whole),
        reporter_(name_, publisher_) {}

  /// Gives what the node has failed at; empty: nothing.
  std::string run(const ConfigNode& config, const NodeFactory& make_node,
                  const std::function<void()>& configured) {
    make(config, make_node);
    configured();
    node_->connect(inputs_);
    inputs_.subscribe<command_t>("COMMAND", 100, [this](const command_t& c) { on_command(c); });
    Receiver receiver(bus_, inputs_);
    yield_to_receivers();  // after the receivers' threads have started
    spdlog::info("{} {} runs", name_, lcmslam_version);

    // A report counts what is in a map: too much to be asked for after each message.
    Clock::time_point next_look = Clock::now();
    Clock::duration wait{0};
    StatusPace pace;
    while (!stop_requested()) {
      Arrival arrival;
      if (receiver.take(arrival, wait)) handle(arrival);
      const auto work = node_->work();
      wait = std::min<Clock::duration>(work.value_or(longest_wait), longest_wait);
      if (Clock::now() >= next_look) {
        const NodeReport report = with_stopped(node_->report(), receiver.stopped());
        watch_.look(main_thread_time(), Clock::now());
        const std::int64_t troubles =
            inputs_.refused() + receiver.refused() + commands_refused_ + report.refused + watch_.stretches();
        if (pace.due(report, troubles, Clock::now())) publish_status(report, receiver);
        next_look = Clock::now() + look_period;
      }
      wait = std::max(Clock::duration{0}, std::min(wait, next_look - Clock::now()));
    }
    drain(receiver);
    node_->finish();
    NodeReport report = node_->report();
    const bool failed = report.state == status_t::FAILED;
    if (!failed) report.state = status_t::STOPPING;
    publish_status(report, receiver);
    spdlog::info("{} stops", name_);
    return failed ? report.detail : "";
  }

 private:
  /// What a node cannot be made from is wrong configuration, say a folder without data.
  void make(const ConfigNode& config, const NodeFactory& make_node) {
    try {
      node_ = make_node(config, publisher_);
    } catch (const std::exception& error) {
      throw ConfigError(error.what());
    }
  }

  /// What was sent before the stop must not be lost: a map's last part, say.
  void drain(Receiver& receiver) {
    const auto end = Clock::now() + longest_drain;
    Arrival arrival;
    while (Clock::now() < end && receiver.take(arrival, longest_wait)) handle(arrival);
  }

  void handle(const Arrival& arrival) {
    // Registered when the message has been decoded, before its handler runs: the answer may come from there.
    if (arrival.input->primary)
      arrival.input->on_seen = [&](Utime utime) { reporter_.arrived(utime, arrival.time); };
    arrival.deliver();
  }

  void on_command(const command_t& command) {
    const bool meant = command.target.empty() || command.target == name_;
    if (meant && needs_confirmation(command) && !is_confirmed(command, name_, publisher_.sender()))
      refuse(command);
    else if (meant && command.name == "stop")
      return request_stop();
    else if (meant)
      return node_->command(command);
    node_->overhear(command);
  }

  void refuse(const command_t& command) {
    ++commands_refused_;
    const bool shown = (commands_refused_ & (commands_refused_ - 1)) == 0;  // the 1st, 2nd, 4th, 8th ...
    if (shown)
      spdlog::warn("COMMAND '{}' of {:08x} is refused, its keys and values do not confirm it ({} so far)",
                   printable(command.name.substr(0, 20)), static_cast<std::uint32_t>(command.sender),
                   commands_refused_);
  }

  void publish_status(NodeReport report, Receiver& receiver) {
    if (commands_refused_ > 0)
      report.values.emplace_back("commands_refused", static_cast<double>(commands_refused_));
    if (publisher_.failed() > 0)
      report.values.emplace_back("send_failures", static_cast<double>(publisher_.failed()));
    if (watch_.stretches() > 0)
      report.values.emplace_back("starved", static_cast<double>(watch_.stretches()));
    publisher_.publish("STATUS", reporter_.gather(report, inputs_, receiver));
  }

  std::string name_;
  LcmBus& bus_;
  LcmPublisher publisher_;
  StatusReporter reporter_;
  Inputs inputs_;
  std::unique_ptr<Node> node_;
  std::int64_t commands_refused_ = 0;
  ProcessorWatch watch_;
};

}  // namespace

int run_process(int argc, char** argv, const std::string& name, const std::string& description,
                const NodeFactory& make_node) {
  keep_freed_memory();
  ProcessOptions options;
  int exit_code = 0;
  if (!parse_options(argc, argv, name, description, options, exit_code)) return exit_code;
  spdlog::set_default_logger(spdlog::stderr_color_mt(name, log_colours(STDERR_FILENO)));
  spdlog::set_level(spdlog::level::from_str(options.log_level));
  install_stop_signals(longest_stop);
  try {
    const ProcessConfig config = process_config(options, name);
    LcmBus bus(options.lcm_url);
    if (!bus.usable()) {
      spdlog::error("LCM cannot use {}: no multicast route? Try: ip route add 224.0.0.0/4 dev lo",
                    options.lcm_url);
      return 1;
    }
    const std::string failure =
        Process(name, bus, largest_whole_message(options.lcm_url)).run(config.section, make_node, [&] {
          config.file.finish();
        });
    if (!failure.empty()) spdlog::error("{}", failure);
    return failure.empty() ? 0 : 1;
  } catch (const ConfigError& error) {
    spdlog::error("{}", error.what());
    return 2;
  } catch (const std::exception& error) {
    spdlog::error("{} failed: {}", name, error.what());
    return 1;
  }
}

}  // namespace lcmslam

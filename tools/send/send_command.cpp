#include <iostream>

#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/commands.hpp"
#include "tools/parse_command.hpp"
#include "tools/send/order.hpp"

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;

/// Every process sends STATUS once a second. Whoever hears an order that must be confirmed is confirmed: for
/// those all are waited for, not just the ones that are asked.
constexpr std::chrono::milliseconds longest_look{3000}, look_at_all{1500};

std::string words_in_help() {
  std::string text;
  for (const OrderWord& word : order_words()) text += "\n  " + word.name + ": " + word.meaning;
  return text;
}

std::vector<std::string> names_of_words() {
  std::vector<std::string> names;
  for (const OrderWord& word : order_words()) names.push_back(word.name);
  return names;
}

/// Hears who is there, sends, and hears the answers.
class Conversation {
 public:
  Conversation(const std::string& lcm_url, Order& order, std::int64_t sender)
      : bus_(usable(lcm_url)),
        order_(order),
        publisher_(bus_->lcm(), sender, largest_whole_message(lcm_url)) {
    inputs_.subscribe<status_t>("STATUS", 1000, [this](const status_t& s) { order_.hear(s); });
    inputs_.subscribe<map_reply_t>("MAP_REPLY", 100, [this](const map_reply_t& r) { order_.hear(r); });
    receiver_.emplace(*bus_, inputs_);
  }

  /// Until `enough` says so, the time is over or Ctrl-C comes.
  void listen(Clock::duration longest, const std::function<bool()>& enough) {
    const auto end = Clock::now() + longest;
    while (!enough() && Clock::now() < end && !stop_requested()) {
      Arrival arrival;
      if (receiver_->take(arrival, std::chrono::milliseconds(50))) arrival.deliver();
    }
  }

  void send(const std::string& folder, const std::string& formats) {
    if (order_.is_request()) {
      publisher_.publish("MAP_REQUEST", order_.request(folder, formats));
    } else {
      for (const command_t& command : order_.commands()) publisher_.publish("COMMAND", command);
    }
    order_.sent();
  }

 private:
  static std::unique_ptr<LcmBus> usable(const std::string& lcm_url) {
    auto bus = std::make_unique<LcmBus>(lcm_url);
    if (!bus->usable()) throw std::runtime_error(lcm_url + " cannot be used; ./lcmslam doctor says why");
    return bus;
  }

  std::unique_ptr<LcmBus> bus_;
  Order& order_;
  LcmPublisher publisher_;
  Inputs inputs_;
  std::optional<Receiver> receiver_;
};

/// True when all is done as it was asked.
bool tell(const std::vector<Order::Answer>& answers) {
  bool good = true;
  for (const Order::Answer& answer : answers) {
    (answer.good ? std::cout : std::cerr) << answer.process << ": " << answer.text << std::endl;
    good &= answer.good;
  }
  return good;
}

}  // namespace

int send_command(int argc, char** argv) {
  std::string word, folder, formats, lcm_url;
  std::vector<std::string> to;
  double seconds = 30;
  CLI::App app{
      "Sends an order to the running graph and says what each process answers; exit code 0 when all "
      "is done. Orders:" +
          words_in_help(),
      "lcmslam send"};
  app.add_option("order", word, "what is to be done")->required()->check(CLI::IsMember(names_of_words()));
  auto* name = app.add_option("name", folder, "export: folder below the run's (default: the run's own)");
  app.add_option("--to", to, "these processes alone (default: all that the order is for)")
      ->check(CLI::IsMember(process_names()));
  app.add_option("--format", formats,
                 "export: ply, pcd, png, mesh, octomap, grid, several separated by commas (default: all)");
  app.add_option("--seconds", seconds, "wait so long for the answers (30)")->check(CLI::Range(0.1, 3600.0));
  app.add_option("--lcm-url", lcm_url,
                 "LCM provider; default LCM_DEFAULT_URL or " + std::string(default_lcm_url));
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (word != "export" && (*name || !formats.empty())) {
    std::cerr << "lcmslam send: '" << word << "' takes no name and no --format; 'export' does\n";
    return 2;
  }
  if (lcm_url.empty()) lcm_url = lcm_url_from_environment();

  install_stop_signals(0);
  const std::int64_t sender = draw_sender();
  std::optional<Order> order;
  try {
    order.emplace(word, to, sender);
  } catch (const std::invalid_argument& error) {
    std::cerr << "lcmslam send: --to: " << error.what() << "\n";
    return 2;
  }
  Conversation conversation(lcm_url, *order, sender);
  const auto begin = Clock::now();
  conversation.listen(longest_look, [&] {
    return order->complete() && (!order->concerns_all() || Clock::now() - begin > look_at_all);
  });
  if (const std::string nobody = order->nobody(); !nobody.empty())
    throw std::runtime_error("nothing is sent: " + nobody + " on " + lcm_url +
                             "; is the graph running, and on this bus (--lcm-url)?");
  conversation.send(folder, formats);
  conversation.listen(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)),
                      [&] { return order->all_answered(); });
  return tell(order->answers(seconds)) ? 0 : 1;
}

}  // namespace lcmslam

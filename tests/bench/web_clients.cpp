// What it costs to be watched: a server that shows a growing map, with 0 to 20 browsers, and how soon a
// command is answered while maps fill the link. Browsers run in a process of their own, so that the CPU that
// is told is the server's.
//
//   build/release/bin/web_clients [SECONDS]

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>
#include <vector>

#include <lcmslam/web/web_server.hpp>
#include "tests/support/web_client.hpp"

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void put(Board& board, const char* channel, const std::string& key, std::size_t size, Haste haste) {
  static char stamp = 0;
  auto bytes = std::make_shared<std::string>(size, 'x');
  bytes->front() = ++stamp;
  board.put({channel, key, "{}", std::move(bytes), haste, 0, {}});
}

void watch(int port, Clock::time_point until) {
  testing::WebClient browser(port);
  browser.patience = 100;
  if (!browser.open_socket("/live?parts=1")) return;
  std::size_t got = 0;
  while (Clock::now() < until)
    if (const auto message = browser.hear()) {
      got += message->size();
      browser.say(R"({"got":)" + std::to_string(got) + "}");
    }
}

/// Answers' times while one browser takes 100 MB of maps; s, sorted.
std::vector<double> command_times(int port, Clock::time_point until) {
  std::vector<double> times;
  testing::WebClient browser(port);
  if (!browser.open_socket("/command")) return times;
  while (Clock::now() < until) {
    const auto begin = Clock::now();
    browser.say("{}");
    if (!browser.hear()) break;
    times.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::sort(times.begin(), times.end());
  return times;
}

/// Runs `browsers` in another process while the board lives as in a drive: poses at 12 Hz, images of 40 kB at
/// 10 Hz, a cloud of 200 kB a second. Returns CPU of this process, cores.
double cost(Board& board, double seconds, const std::function<void(Clock::time_point)>& browsers) {
  const auto until =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    browsers(until);
    std::fflush(stdout);
    _exit(0);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const double before = cpu_seconds();
  const auto begin = Clock::now();
  for (int i = 0; Clock::now() < until; ++i) {
    put(board, "poses", "", 900, Haste::live);
    put(board, "image", "", 40'000, Haste::picture);
    if (i % 10 == 0) put(board, "points", std::to_string(i), 200'000, Haste::bulk);
    std::this_thread::sleep_for(std::chrono::milliseconds(85));
  }
  const double used = cpu_seconds() - before;
  waitpid(child, nullptr, 0);
  return used / std::chrono::duration<double>(Clock::now() - begin).count();
}

void run(double seconds) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("web_clients-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "index.html") << "page";
  Board board;
  WebSettings settings;
  settings.port = 0;
  WebServer::Handlers handlers;
  handlers.command = [](std::uint64_t, const std::string& text, const WebServer::Reply& reply) {
    reply(text);
  };
  const WebServer server(settings, folder, board, handlers);
  const int port = server.port();

  double alone = 0;
  for (const int clients : {0, 1, 5, 20}) {
    const double used = cost(board, seconds, [&](Clock::time_point until) {
      std::vector<std::thread> threads;
      for (int i = 0; i < clients; ++i) threads.emplace_back([&] { watch(port, until); });
      for (std::thread& thread : threads) thread.join();
    });
    if (clients == 0) alone = used;
    std::printf("%2d browsers: %5.2f %% of a core", clients, 100 * used);
    if (clients > 0) std::printf(", %.2f %% each", 100 * (used - alone) / clients);
    std::printf("\n");
  }
  for (int i = 0; i < 500; ++i) put(board, "mesh", std::to_string(i), 200'000, Haste::bulk);
  cost(board, seconds, [&](Clock::time_point until) {
    std::vector<std::thread> threads;
    for (int i = 0; i < 3; ++i) threads.emplace_back([&] { watch(port, until); });
    const std::vector<double> times = command_times(port, until);
    for (std::thread& thread : threads) thread.join();
    if (times.empty()) return;
    std::printf("commands while three browsers take 100 MB each: median %.2f, p95 %.2f ms (%zu)\n",
                1e3 * times[times.size() / 2], 1e3 * times[times.size() * 95 / 100], times.size());
  });
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  lcmslam::run(argc > 1 ? std::atof(argv[1]) : 5);
  return 0;
}

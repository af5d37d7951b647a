#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/map_client/map_client.hpp>
#include "tools/commands.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;

/// "near=1,2,0.5 radius=0.4" as members of a question: numbers, lists of numbers, or texts; a list of rows
/// has semicolons between them, and a semicolon at its end where it has one row.
json value_of(const std::string& text) {
  const json value = json::parse(text, nullptr, false);
  if (!value.is_discarded()) return value;
  if (text.find_first_not_of("0123456789+-.eE,;") != std::string::npos) return text;
  std::string rows = "[" + text + "]";
  if (text.find(';') != std::string::npos) {
    rows = "[[";
    for (const char c : text.back() == ';' ? text.substr(0, text.size() - 1) : text)
      rows += c == ';' ? std::string("],[") : std::string(1, c);
    rows += "]]";
  }
  const json list = json::parse(rows, nullptr, false);
  return list.is_discarded() ? json(text) : list;
}

/// Of the list of rows that an error names: "1,2,3" is a list of numbers, and only "1,2,3;" one of a row.
std::string advice_on_rows(const std::string& error, const std::vector<std::string>& members) {
  const bool in_a_row =
      error.find(" numbers") != std::string::npos && error.find("' is [") == std::string::npos;
  if (!in_a_row) return "";
  for (const std::string& member : members) {
    const bool is_row =
        member.find(',') != std::string::npos && member.find_first_of(";[") == std::string::npos;
    if (is_row && error.find("'" + member.substr(0, member.find('=')) + "'") != std::string::npos)
      return " (rows end with a semicolon: " + member + ";)";
  }
  return "";
}

Question question_of(const std::string& ask, const std::vector<std::string>& members) {
  if (ask.front() == '{') return parse_question(ask);
  json question = {{"ask", ask}};
  for (const std::string& member : members) {
    const std::size_t equals = member.find('=');
    if (equals == std::string::npos || equals == 0)
      throw std::invalid_argument("'" + member + "' is no NAME=VALUE");
    question[member.substr(0, equals)] = value_of(member.substr(equals + 1));
  }
  try {
    return parse_question(question.dump());
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(error.what() + advice_on_rows(error.what(), members));
  }
}

int tell_times(MapClient& client, const Question& question, int repeat) {
  std::vector<double> times;  // ms
  for (int i = 0; i < repeat; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    client.ask(question);
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    std::this_thread::sleep_for(
        std::chrono::milliseconds(20));  // a planner's rate; it shall not load the machine
  }
  std::sort(times.begin(), times.end());
  const auto share = [&](double p) {
    return times[static_cast<std::size_t>(p * static_cast<double>(times.size() - 1))];
  };
  std::cout << fmt::format("{} answers: median {:.1f} ms, p95 {:.1f} ms, longest {:.1f} ms\n", repeat,
                           share(0.5), share(0.95), times.back());
  return 0;
}

}  // namespace

int query_command(int argc, char** argv) {
  std::string ask, out, lcm_url;
  std::vector<std::string> members;
  int repeat = 0;
  CLI::App app{
      "Asks the running map server and prints the answer, JSON. Questions (docs/QUERIES.md), with what they "
      "need behind them: distance, collision, path, space, cloud, mesh, planes, objects, landmarks, "
      "frontiers, grid, localise:\n  lcmslam query distance \"points=1,0,0.5;\"\n  lcmslam query planes "
      "near=2,0,0.7 radius=1 "
      "supporting=true\n  lcmslam query mesh from=0,-1,0 to=3,1,2 --out part.ply",
      "lcmslam query"};
  app.add_option("question", ask, "what is asked, or the whole question as JSON")->required();
  app.add_option("members", members, "NAME=VALUE; a point is 1,2,3, a list of them has semicolons between");
  app.add_option("--out", out, "file that takes the answer; a cloud or a mesh needs one");
  app.add_option("--repeat", repeat, "ask so often and print how long the answers took")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--lcm-url", lcm_url, "LCM provider; default LCM_DEFAULT_URL or lcmslam's own");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;

  Question question;
  try {
    question = question_of(ask, members);
  } catch (const std::invalid_argument& error) {
    std::cerr << "lcmslam query: " << error.what() << "\n";
    return 2;
  }
  const bool is_file = std::holds_alternative<CloudQuestion>(question.what) ||
                       std::holds_alternative<MeshQuestion>(question.what);
  if (is_file && out.empty()) {
    std::cerr << "lcmslam query: the answer is a file, --out FILE says where it goes\n";
    return 2;
  }
  MapClient client(lcm_url);
  if (repeat > 0) return tell_times(client, question, repeat);
  const MapClient::Reply reply = client.ask(question);
  if (!out.empty()) {
    write_atomically(FilePlace(out), reply.bytes);
    std::cout << "wrote " << out << ": " << reply.content << ", frame " << reply.frame << ", map version "
              << reply.map_version << "\n";
  } else {
    std::cout << reply.bytes << "\n";
  }
  return 0;
}

}  // namespace lcmslam

#include "tools/farm/farm_report.hpp"

#include <fmt/format.h>
#include <algorithm>

#include <lcmslam/evaluation/median.hpp>
#include <lcmslam/evaluation/table.hpp>

namespace lcmslam {
namespace {

/// For HTML and XML, as text and between double quotes; control characters, which XML 1.0 lacks, are left
/// out.
std::string marked_up(const std::string& text) {
  std::string safe;
  for (const char c : text) switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) safe += c;
    }
  return safe;
}

std::string ate_text(const std::optional<double>& ate) {
  return ate ? fixed_number(*ate, 4) : "-";
}

const char* verdict(const FarmResult& result) {
  if (result.passed()) return "passed";
  return result.has_summary ? "failed" : "no result";
}

std::string restarts_text(const FarmResult& result) {
  std::string text;
  for (const auto& [mapper, restarts] :
       {std::pair("icp", result.icp_restarts), std::pair("fastslam", result.fastslam_restarts)})
    if (restarts > 0)
      text += fmt::format("{}: {} began a new map {} time{}: its error is of the newest alone\n", result.name,
                          mapper, restarts, restarts == 1 ? "" : "s");
  return text;
}

std::optional<double> median(const std::vector<FarmResult>& results, std::optional<double> FarmResult::*ate) {
  std::vector<double> values;
  for (const FarmResult& result : results)
    if (result.*ate) values.push_back(*(result.*ate));
  if (values.empty()) return std::nullopt;
  return lcmslam::median(std::move(values));
}

std::string totals(const std::vector<FarmResult>& results) {
  const auto count = [&](const char* what) {
    return std::count_if(results.begin(), results.end(),
                         [&](const FarmResult& r) { return std::string(verdict(r)) == what; });
  };
  return fmt::format(
      "{} logs: {} passed, {} failed, {} without a result; median ATE: icp {} m, fastslam {} m, "
      "odometry {} m",
      results.size(), count("passed"), count("failed"), count("no result"),
      ate_text(median(results, &FarmResult::icp)), ate_text(median(results, &FarmResult::fastslam)),
      ate_text(median(results, &FarmResult::odometry)));
}

std::string list_text(const std::string& what, const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return names.empty() ? "" : fmt::format("{}: {}\n", what, text);
}

// Quiet, readable on a phone and in the dark; verdicts are words, so that no colour is needed to tell them.
constexpr const char* style = R"(
:root { color-scheme: light dark; --line: #8884; --soft: #888; --bad: #b3261e; --good: #1b6e3c }
@media (prefers-color-scheme: dark) { :root { --bad: #ff8a80; --good: #7bd6a0 } }
body { font: 15px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 1100px; padding: 1.5rem 1rem }
h1 { font-size: 1.4rem } h2 { font-size: 1.1rem; margin-top: 2rem } p, pre { color: var(--soft) }
pre { overflow-x: auto } article { border-top: 1px solid var(--line); padding: 1rem 0 }
article h3 { font-size: 1rem; margin: 0 } .passed { color: var(--good) } .failed { color: var(--bad) }
ul { margin: .4rem 0; padding-left: 1.2rem } .pictures { display: flex; gap: .6rem; overflow-x: auto }
.pictures img { height: 190px; border-radius: 4px; background: #fff } dl { display: flex; flex-wrap: wrap; gap: 0 1.4rem; margin: .4rem 0 }
dt { color: var(--soft) } dd { margin: 0 0 0 .4rem; font-variant-numeric: tabular-nums } dl div { display: flex }
)";

std::string article(const FarmResult& result) {
  const std::string name = marked_up(result.name);
  std::string html =
      fmt::format("<article><h3><a href=\"{0}/\">{0}</a> <span class=\"{1}\">{2}</span></h3>\n", name,
                  result.passed() ? "passed" : "failed", verdict(result));
  if (!result.failures.empty()) {
    html += "<ul>";
    for (const std::string& failure : result.failures) html += "<li>" + marked_up(failure) + "</li>";
    html += "</ul>\n";
  }
  if (!result.has_summary) return html + "</article>\n";
  if (const std::string restarts = restarts_text(result); !restarts.empty())
    html += "<p>" + marked_up(restarts) + "</p>\n";
  html += "<dl>";
  for (const auto& [what, ate] : {std::pair("6-D SLAM", result.icp), std::pair("FastSLAM", result.fastslam),
                                  std::pair("odometry", result.odometry)})
    html += fmt::format("<div><dt>{}</dt><dd>{} m</dd></div>", what, ate_text(ate));
  html +=
      fmt::format("<div><dt>frames</dt><dd>{:.0f}</dd></div><div><dt>took</dt><dd>{:.1f} s</dd></div></dl>\n",
                  result.frames, result.seconds);
  html += "<div class=\"pictures\">";
  for (const auto& [file, what] : {std::pair("trajectories.png", "paths from above"),
                                   std::pair("icp_top.png", "the dense map from above"),
                                   std::pair("fastslam_top.png", "the landmarks from above")})
    html += fmt::format("<img loading=\"lazy\" src=\"{0}/{1}\" alt=\"{0}: {2}\">", name, file, what);
  return html + "</div></article>\n";
}

}  // namespace

std::string farm_table(const std::vector<FarmResult>& results) {
  Table table({"log", "verdict", "icp m", "fastslam m", "odometry m", "new maps", "frames", "s"});
  for (const FarmResult& r : results)
    table.add({r.name, verdict(r), ate_text(r.icp), ate_text(r.fastslam), ate_text(r.odometry),
               std::to_string(r.icp_restarts + r.fastslam_restarts), fixed_number(r.frames, 0),
               fixed_number(r.seconds, 1)});
  std::string text = table.text() + "\n" + totals(results) + "\n";
  for (const FarmResult& r : results) text += restarts_text(r);
  for (const FarmResult& r : results)
    for (const std::string& failure : r.failures) text += fmt::format("{}: {}\n", r.name, failure);
  return text;
}

std::string comparison_text(const FarmComparison& comparison) {
  constexpr std::size_t most = 5;
  std::string text;
  for (const PathChange& path : comparison.paths) {
    text += list_text(path.path + std::string(": an error before alone"), path.only_before) +
            list_text(path.path + std::string(": an error now alone"), path.only_after) +
            list_text(path.path + std::string(": a new map was begun, so in no ratio"), path.restarted);
    if (path.logs.empty()) continue;
    text +=
        fmt::format("{}: errors x {:.3f} over {} logs (95 % from {} to {}): {}\n", path.path, path.ratio,
                    path.logs.size(), fixed_number(path.low, 3), fixed_number(path.high, 3), path.verdict());
    const auto line = [&](const LogChange& log) {
      text +=
          fmt::format("  {}: {:.4f} -> {:.4f} m (x {:.2f})\n", log.name, log.before, log.after, log.ratio());
    };
    for (std::size_t i = 0; i < std::min(most, path.logs.size()) && path.logs[i].ratio() > 1; ++i)
      line(path.logs[i]);
    const std::size_t first = path.logs.size() - std::min(most, path.logs.size());
    for (std::size_t i = first; i < path.logs.size(); ++i)
      if (path.logs[i].ratio() < 1) line(path.logs[i]);
  }
  return text + list_text("passed before and not now", comparison.broken) +
         list_text("passes now and did not before", comparison.mended) +
         list_text("only before", comparison.missing) + list_text("only now", comparison.added);
}

std::string farm_page(const std::string& title, const std::vector<FarmResult>& results,
                      const std::optional<FarmComparison>& comparison) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0}</title><style>{1}</style></head><body>\n<h1>{0}</h1>\n<p>{2}</p>\n",
      marked_up(title), style, marked_up(totals(results)));
  if (comparison) {
    std::string lines;  // markup of each line, their ends kept
    std::string text = comparison_text(*comparison);
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      lines += marked_up(text.substr(begin, end - begin)) + "\n";
      begin = end + 1;
    }
    html += "<h2>Beside the other farm</h2>\n<pre>" + lines + "</pre>\n";
  }
  html += "<h2>The worst first</h2>\n";
  for (const FarmResult& result : results) html += article(result);
  return html + "</body></html>\n";
}

std::string junit_xml(const std::string& suite, const std::vector<FarmResult>& results) {
  std::size_t failed = 0, without = 0;
  double seconds = 0;
  std::string cases;
  for (const FarmResult& r : results) {
    seconds += r.seconds;
    failed += r.has_summary && !r.passed();
    without += !r.has_summary;
    cases += fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", marked_up(suite),
                         marked_up(r.name), r.seconds);
    if (r.passed()) {
      cases += "/>\n";
      continue;
    }
    const char* const element = r.has_summary ? "failure" : "error";
    cases += fmt::format(">\n    <{} message=\"{}\">", element, marked_up(r.failures.front()));
    for (const std::string& failure : r.failures) cases += marked_up(failure) + "\n";
    cases += fmt::format("</{}>\n  </testcase>\n", element);
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
      "errors=\"{}\" time=\"{:.3f}\">\n{}</testsuite>\n",
      marked_up(suite), results.size(), failed, without, seconds, cases);
}

}  // namespace lcmslam

#include <filesystem>
#include <iostream>

#include <lcmslam/files/atomic_file.hpp>
#include "tools/commands.hpp"
#include "tools/farm/farm.hpp"
#include "tools/farm/farm_report.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int collect_command(int argc, char** argv) {
  namespace fs = std::filesystem;
  fs::path folder, against, expect, junit, html;
  CLI::App app{
      "The results of many logs (lcmslam batch CONFIG LOG... --out FOLDER) in one table and one page, the "
      "worst "
      "first, and as JUnit's XML; against another farm's, what became better and worse. Exit code 0: all "
      "passed; 1: some did not reach what was expected; 2: some have no result.",
      "lcmslam collect"};
  app.add_option("folder", folder, "the farm's")->required()->check(CLI::ExistingDirectory);
  app.add_option("--against", against, "another farm's folder, of the same logs")
      ->check(CLI::ExistingDirectory);
  app.add_option("--expect", expect,
                 "bars that runs must reach (YAML); default: FOLDER/expect.yaml if it is there")
      ->check(CLI::ExistingFile);
  app.add_option("--html", html, "page to write, beside the results (default FOLDER/report.html)");
  app.add_option("--junit", junit, "JUnit's XML to write (default FOLDER/junit.xml)");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (expect.empty() && fs::exists(folder / "expect.yaml")) expect = folder / "expect.yaml";
  const Expectations expectations = expect.empty() ? Expectations() : Expectations(expect);
  std::vector<FarmResult> results = read_results(folder, expectations);
  std::optional<FarmComparison> comparison;
  if (!against.empty()) comparison = compare_farms(read_results(against, expectations), results);
  put_worst_first(results);

  const std::string name = fs::weakly_canonical(folder).filename().string();
  std::cout << farm_table(results);
  if (comparison) std::cout << "\n" << comparison_text(*comparison);
  write_atomically(FilePlace(html.empty() ? folder / "report.html" : html),
                   farm_page("Farm " + name, results, comparison));
  write_atomically(FilePlace(junit.empty() ? folder / "junit.xml" : junit),
                   junit_xml("lcmslam." + name, results));
  std::cout << "page: " << (html.empty() ? folder / "report.html" : html).string() << "\n";
  return exit_code_of(results);
}

}  // namespace lcmslam

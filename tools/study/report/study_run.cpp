#include "tools/study/report/study_run.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <opencv2/core/version.hpp>
#include <stdexcept>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/runtime/version.hpp>
#include "tools/study/report/study_json.hpp"
#include "tools/study/report/study_page.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

nlohmann::json versions() {
  return {{"lcmslam", lcmslam_version},
          {"compiler", __VERSION__},
          {"opencv", CV_VERSION},
          {"eigen", std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                        std::to_string(EIGEN_MINOR_VERSION)}};
}

std::string read_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read the picture " + file.string());
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Pictures move to `out`/pictures/NAME; the JSON names them from `out`.
void keep_pictures(const ExperimentResult& result, const std::string& name, const fs::path& out,
                   nlohmann::json& json) {
  const fs::path folder = fs::path("pictures") / name;
  for (std::size_t i = 0; i < result.pictures.size(); ++i) {
    const fs::path file = folder / result.pictures[i].file.filename();
    fs::create_directories(out / folder);
    write_atomically(out / file, read_file(result.pictures[i].file));
    json["pictures"][i]["file"] = file.string();
  }
}

/// A folder for logs and pictures that is gone afterwards.
class WorkFolder {
 public:
  explicit WorkFolder(fs::path path) : path_(std::move(path)) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Without its name and title. Throws what the experiment throws.
nlohmann::json run_experiment(const Experiment& experiment, const StudyContext& context,
                              const fs::path& out) {
  const Clock::time_point begin = Clock::now();
  const ExperimentResult result = experiment.run(context);
  nlohmann::json json = experiment_json(result);
  json["timing"]["seconds"] = seconds_since(begin);
  keep_pictures(result, experiment.name, out, json);
  json["status"] = "done";
  return json;
}

/// 2 to 4 of the thesis, then its future work, then what is beyond it.
int chapter(const Experiment& experiment) {
  const std::size_t digit = experiment.thesis.find_first_of("0123456789");
  if (digit != std::string::npos) return experiment.thesis[digit] - '0';
  return experiment.thesis.empty() ? 11 : 10;
}

}  // namespace

std::vector<Experiment> study_experiments() {
  std::vector<Experiment> all = mapping_experiments();
  for (Experiment& experiment : registration_experiments()) all.push_back(std::move(experiment));
  std::stable_sort(all.begin(), all.end(),
                   [](const Experiment& a, const Experiment& b) { return chapter(a) < chapter(b); });
  return all;
}

std::vector<Experiment> experiments_named(std::vector<Experiment> experiments, const std::string& name) {
  if (name.empty()) return experiments;
  std::string names;
  for (Experiment& experiment : experiments) {
    if (experiment.name == name) return {std::move(experiment)};
    names += (names.empty() ? "" : ", ") + experiment.name;
  }
  throw std::invalid_argument("no experiment is called '" + name + "'; there are " + names);
}

nlohmann::json run_experiments(const std::vector<Experiment>& experiments, const StudyRunSettings& settings) {
  nlohmann::json report = {{"versions", versions()},
                           {"quick", settings.quick},
                           {"seeds", settings.seeds},
                           {"with_recordings", !settings.data.empty()},
                           {"experiments", nlohmann::json::array()}};
  const Clock::time_point begin = Clock::now();
  for (const Experiment& experiment : experiments) {
    const std::size_t done = report["experiments"].size();
    const auto tell = [&](double part) {
      settings.progress(experiment.name, done, part, experiments.size(), seconds_since(begin));
    };
    tell(0);
    const WorkFolder work(settings.out / "work" / experiment.name);
    const StudyContext context{settings.quick, settings.seeds, work.path(), settings.data, tell};
    nlohmann::json json;
    std::string error;
    try {
      json = run_experiment(experiment, context, settings.out);
    } catch (const std::exception& problem) {
      error = problem.what();
      json = {{"status", "failed"}, {"error", error}};
    }
    json["name"] = experiment.name;
    json["title"] = experiment.title;
    json["thesis"] = experiment.thesis;
    report["experiments"].push_back(json);
    settings.ended(experiment.name, error);
  }
  return report;
}

bool run_study(const std::vector<Experiment>& experiments, const StudyRunSettings& settings) {
  fs::create_directories(settings.out);
  const nlohmann::json report = run_experiments(experiments, settings);
  std::error_code ignored;
  fs::remove(settings.out / "work", ignored);
  write_atomically(settings.out / "report.json", report.dump(1) + "\n");
  write_atomically(settings.out / "index.html", study_page(report, settings.out, settings.page));
  const auto& list = report["experiments"];
  return std::none_of(list.begin(), list.end(), [](const auto& e) { return e.at("status") == "failed"; });
}

}  // namespace lcmslam

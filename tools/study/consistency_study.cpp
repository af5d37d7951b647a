#include "tools/study/consistency_study.hpp"

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include <lcmslam/evaluation/table.hpp>
#include "tools/batch/batch_run.hpp"
#include "tools/evaluate/robot_truth.hpp"
#include "tools/farm/farm_jobs.hpp"
#include "tools/output_file.hpp"
#include "tools/study/measures.hpp"
#include "tools/study/told_keyframes.hpp"

namespace lcmslam {
namespace {

constexpr double bin_us = 1e6;
constexpr double far = 3;  // times the expectation
constexpr double three_sigmas = 3;
const char* const keyframe_channel = "ICP_GRAPH";

// "kitchen" of kitchen_12.lcmlog.
std::string scene_of(const std::string& log) {
  const std::string stem = std::filesystem::path(log).stem();
  const std::size_t end = stem.find_last_not_of("0123456789");
  return end != std::string::npos && end > 0 && end + 1 < stem.size() && stem[end] == '_'
             ? stem.substr(0, end)
             : stem;
}

std::map<std::string, BelievedPath> published_by(const std::string& log, const ConfigNode& config,
                                                 const std::filesystem::path& folder) {
  BatchOptions options;
  options.config = config;
  options.log = log;
  options.folder = folder;
  options.threads = 1;
  ToldKeyframes keyframes;
  BelievedPoses poses;
  options.heard = [&](const BatchMessage& message) {
    keyframes.hear(message.channel, message.bytes);
    poses.hear(message.channel, message.bytes);
  };
  run_batch(options);
  std::map<std::string, BelievedPath> published = poses.paths();
  if (Trajectory at_the_end = keyframes.path(); !at_the_end.empty())
    published[keyframe_channel].path = std::move(at_the_end);
  return published;
}

/// One log's runs, a channel each.
std::vector<ConsistencyRun> runs_of(const std::string& log, const ConfigNode& config,
                                    const std::filesystem::path& folder, const EvaluationSettings& settings) {
  const Trajectory truth = robot_truth(log);
  std::vector<ConsistencyRun> runs;
  for (const auto& [channel, own] : published_by(log, config, folder)) {
    runs.push_back(consistency_run(truth, own, settings));
    runs.back().scene = scene_of(log);
    runs.back().channel = channel;
  }
  return runs;
}

bool is_planar(const std::vector<MatchedPose>& matches) {
  return std::all_of(matches.begin(), matches.end(), [](const MatchedPose& match) {
    return std::abs(match.T_world_estimate.translation().z()) < 1e-6 &&
           match.T_world_estimate.linear()(2, 2) > 1 - 1e-9;
  });
}

}  // namespace

double chi_square_quantile(double degrees, double normal_quantile) {
  const double probability = 0.5 * std::erfc(-normal_quantile / std::sqrt(2.));
  return boost::math::quantile(boost::math::chi_squared(degrees), probability);
}

ConsistencyRun consistency_run(const std::vector<MatchedPose>& matches) {
  ConsistencyRun run;
  if (matches.size() < 2) {
    run.left_out = matches.size();
    return run;
  }
  const std::vector<int> rows =
      is_planar(matches) ? std::vector<int>{0, 1, 5} : std::vector<int>{0, 1, 2, 3, 4, 5};
  run.components = static_cast<int>(rows.size());
  const MatchedPose& first = matches.front();
  const Eigen::Isometry3d T_map_world = first.T_world_estimate * first.T_world_truth.inverse();
  std::map<std::size_t, std::vector<double>> bins;
  for (auto match = matches.begin() + 1; match != matches.end(); ++match) {
    if (!match->covariance) {
      ++run.left_out;
      continue;
    }
    const Vector6d e = se3_log(match->T_world_estimate.inverse() * T_map_world * match->T_world_truth);
    const Eigen::MatrixXd P = (*match->covariance)(rows, rows);
    const Eigen::LLT<Eigen::MatrixXd> root(P);
    if (root.info() != Eigen::Success) {
      ++run.left_out;
      continue;
    }
    const Eigen::VectorXd seen = e(rows);
    const Eigen::VectorXd white = root.matrixL().solve(seen);
    run.all.push_back(white.squaredNorm());
    run.within_whitened += (white.array().abs() < three_sigmas).cast<double>().mean();
    bins[static_cast<std::size_t>(static_cast<double>(match->utime - first.utime) / bin_us)].push_back(
        run.all.back());
    for (const int i : rows) {
      const auto k = static_cast<std::size_t>(i);
      run.ratio_rms[k] += e(i) * e(i) / (*match->covariance)(i, i);
      run.error_rms[k] += e(i) * e(i);
      run.within[k] += std::abs(e(i)) < three_sigmas * std::sqrt((*match->covariance)(i, i)) ? 1 : 0;
    }
  }
  const auto n = static_cast<double>(std::max<std::size_t>(1, run.all.size()));
  for (auto* squares : {&run.ratio_rms, &run.error_rms})
    for (double& square : *squares) square = std::sqrt(square / n);
  for (double& share : run.within) share /= n;
  run.within_whitened /= n;
  if (bins.empty()) return run;
  run.nees.assign(bins.rbegin()->first + 1, std::nan(""));
  for (const auto& [second, values] : bins) {
    double sum = 0;
    for (const double value : values) sum += value;
    run.nees[second] = sum / static_cast<double>(values.size());
  }
  return run;
}

ConsistencyRun consistency_run(const Trajectory& truth, const BelievedPath& believed,
                               const EvaluationSettings& settings) {
  ConsistencyRun run;
  std::size_t unmatched = believed.path.size();
  try {
    const std::vector<MatchedPose> matches = associate(truth, believed.path, settings);
    unmatched -= matches.size();
    run = consistency_run(matches);
  } catch (const std::invalid_argument&) {  // no believed pose has a true one
  }
  run.left_out += believed.left_out + unmatched;
  return run;
}

std::vector<ConsistencyScore> consistency_scores(const std::vector<ConsistencyRun>& runs) {
  std::map<std::pair<std::string, std::string>, std::vector<const ConsistencyRun*>> groups;
  for (const ConsistencyRun& run : runs) groups[{run.scene, run.channel}].push_back(&run);
  std::vector<ConsistencyScore> scores;
  const double nothing = std::nan("");
  for (const auto& [key, together] : groups) {
    ConsistencyScore score;
    score.scene = key.first;
    score.channel = key.second;
    std::vector<double> all;
    std::array<double, 6> having{};  // poses that have the component
    std::vector<const ConsistencyRun*> members;
    for (const ConsistencyRun* run : together) {
      score.left_out += run->left_out;
      if (run->all.empty())
        score.not_judged.push_back(run->log);
      else
        members.push_back(run);
    }
    score.runs = static_cast<int>(members.size());
    if (members.empty()) {
      for (double* figure : {&score.components, &score.low, &score.high, &score.inside, &score.above,
                             &score.far_above, &score.mean, &score.median, &score.within_whitened})
        *figure = nothing;
      scores.push_back(score);
      continue;
    }
    for (const ConsistencyRun* run : members) {
      score.components += run->components;
      score.seconds = std::max(score.seconds, run->nees.size());
      all.insert(all.end(), run->all.begin(), run->all.end());
      score.poses += run->all.size();
      const auto poses = static_cast<double>(run->all.size());
      score.within_whitened += poses * run->within_whitened;
      for (std::size_t i = 0; i < 6; ++i) {
        if (run->ratio_rms[i] > 0) having[i] += poses;
        score.within[i] += poses * run->within[i];
        score.ratio_rms[i] += poses * run->ratio_rms[i] * run->ratio_rms[i];
        score.error_rms[i] += poses * run->error_rms[i] * run->error_rms[i];
      }
    }
    score.components /= score.runs;
    const auto poses = static_cast<double>(std::max<std::size_t>(1, score.poses));
    for (std::size_t i = 0; i < 6; ++i) {
      const double count = std::max(1., having[i]);
      score.within[i] /= count;
      score.ratio_rms[i] = std::sqrt(score.ratio_rms[i] / count);
      score.error_rms[i] = std::sqrt(score.error_rms[i] / count);
    }
    score.within_whitened /= poses;
    const double d = score.components, n = score.runs;
    score.low = chi_square_quantile(n * d, -1.96) / n;
    score.high = chi_square_quantile(n * d, 1.96) / n;
    for (std::size_t second = 0; second < score.seconds; ++second) {
      double sum = 0, count = 0;
      for (const ConsistencyRun* run : members)
        if (second < run->nees.size() && std::isfinite(run->nees[second])) {
          sum += run->nees[second];
          ++count;
        }
      if (count < n) continue;  // the band is that of all runs
      ++score.judged;
      const double mean = sum / count;
      score.inside += mean >= score.low && mean <= score.high ? 1 : 0;
      score.above += mean > score.high ? 1 : 0;
      score.far_above += mean > far * d ? 1 : 0;
    }
    for (double* share : {&score.inside, &score.above, &score.far_above})
      *share = score.judged > 0 ? *share / static_cast<double>(score.judged) : nothing;
    for (const double value : all) score.mean += value / static_cast<double>(all.size());
    score.median = median(all);
    scores.push_back(score);
  }
  return scores;
}

ConsistencyRuns study_consistency(const std::vector<std::string>& logs, const ConfigNode& config,
                                  const std::string& folder, double clock_offset) {
  ConsistencyRuns judged;
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  settings.clock_offset = clock_offset;
  for (const FarmJob& job : farm_jobs(std::vector<std::filesystem::path>(logs.begin(), logs.end()))) {
    try {
      for (ConsistencyRun& run :
           runs_of(job.log.string(), config, std::filesystem::path(folder) / job.name, settings)) {
        run.log = job.name;
        judged.runs.push_back(std::move(run));
      }
      std::cout << job.name << ": done" << std::endl;
    } catch (const std::exception& error) {
      throw_when_stopped();
      judged.left_out.push_back(job.name + ": " + error.what());
      std::cout << job.name << ": left out: " << error.what() << std::endl;
    }
  }
  if (judged.runs.empty()) throw std::runtime_error("no log could be judged: " + judged.left_out.back());
  return judged;
}

std::string consistency_table(const std::vector<ConsistencyScore>& scores) {
  Table table({"scene",         "channel",  "runs",     "honest",  "95 % band",
               "median",        "mean",     "inside %", "above %", "> 3x %",
               "error/sigma x", "y",        "z",        "roll",    "pitch",
               "yaw",           "error mm", "mrad",     "seconds", "poses left out"});
  for (const ConsistencyScore& s : scores) {
    std::vector<std::string> row = {
        s.scene,
        s.channel,
        std::to_string(s.runs),
        fixed_number(s.components, s.components == std::round(s.components) ? 0 : 1),
        s.runs > 0 ? fixed_number(s.low, 1) + ".." + fixed_number(s.high, 1) : "-",
        fixed_number(s.median, 1),
        fixed_number(s.mean, 1),
        fixed_number(100 * s.inside, 0),
        fixed_number(100 * s.above, 0),
        fixed_number(100 * s.far_above, 0)};
    for (const double ratio : s.ratio_rms) row.push_back(ratio > 0 ? fixed_number(ratio, 2) : "-");
    const auto& e = s.error_rms;
    row.push_back(fixed_number(1e3 * std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]), 1));
    row.push_back(fixed_number(1e3 * std::sqrt(e[3] * e[3] + e[4] * e[4] + e[5] * e[5]), 1));
    row.push_back(fmt::format("{} of {}", s.judged, s.seconds));
    row.push_back(std::to_string(s.left_out));
    table.add(row);
  }
  std::string text = table.text();
  for (const ConsistencyScore& s : scores)
    for (const std::string& log : s.not_judged)
      text += log + ", " + s.channel + ": no run, as no pose after the first could be judged\n";
  return text;
}

std::string within_table(const std::vector<ConsistencyScore>& scores) {
  Table table({"scene", "channel", "poses", "NEES over honest", "whitened %", "x %", "y %", "z %", "roll %",
               "pitch %", "yaw %"});
  for (const ConsistencyScore& s : scores) {
    std::vector<std::string> row = {s.scene, s.channel, std::to_string(s.poses),
                                    fixed_number(s.mean / s.components, 2),
                                    fixed_number(100 * s.within_whitened, 1)};
    for (std::size_t i = 0; i < 6; ++i)
      row.push_back(s.ratio_rms[i] > 0 ? fixed_number(100 * s.within[i], 1) : "-");
    table.add(row);
  }
  return table.text();
}

nlohmann::json consistency_json(const std::vector<ConsistencyRun>& runs,
                                const std::vector<ConsistencyScore>& scores) {
  nlohmann::json json = {{"runs", nlohmann::json::array()}, {"scenes", nlohmann::json::array()}};
  for (const ConsistencyRun& run : runs)
    json["runs"].push_back({{"log", run.log},
                            {"scene", run.scene},
                            {"channel", run.channel},
                            {"components", run.components},
                            {"nees_by_second", run.nees},
                            {"nees_median", median(run.all)},
                            {"error_over_sigma_rms", run.ratio_rms},
                            {"error_rms", run.error_rms},
                            {"within_three_sigmas", run.within},
                            {"whitened_within_three_sigmas", run.within_whitened},
                            {"poses", run.all.size()},
                            {"left_out", run.left_out}});
  for (const ConsistencyScore& s : scores)
    json["scenes"].push_back({{"scene", s.scene},
                              {"channel", s.channel},
                              {"runs", s.runs},
                              {"not_judged", s.not_judged},
                              {"components", s.components},
                              {"band", {s.low, s.high}},
                              {"seconds", s.seconds},
                              {"seconds_judged", s.judged},
                              {"poses_left_out", s.left_out},
                              {"inside", s.inside},
                              {"above", s.above},
                              {"far_above", s.far_above},
                              {"nees_mean", s.mean},
                              {"nees_median", s.median},
                              {"error_over_sigma_rms", s.ratio_rms},
                              {"error_rms", s.error_rms},
                              {"within_three_sigmas", s.within},
                              {"whitened_within_three_sigmas", s.within_whitened}});
  return json;
}

}  // namespace lcmslam

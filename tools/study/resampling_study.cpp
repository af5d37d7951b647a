#include "tools/study/resampling_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/particles_t.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/batch/batch_run.hpp"
#include "tools/evaluate/pose_log.hpp"
#include "tools/evaluate/robot_truth.hpp"
#include "tools/study/measures.hpp"

namespace lcmslam {
namespace {

std::filesystem::path run(const ResamplingStudySettings& settings, const std::filesystem::path& log,
                          const std::filesystem::path& folder, const std::vector<std::string>& more) {
  std::vector<std::string> overrides = settings.overrides;
  overrides.insert(overrides.end(), more.begin(), more.end());
  BatchOptions options;
  options.config = load_config(settings.config, overrides);
  options.log = log;
  options.folder = folder;
  return run_batch(options).output;
}

bool has_features(const std::filesystem::path& log) {
  LogReader reader(log.string());
  while (const auto event = reader.next_view())
    if (event->channel == "FEATURES") return true;
  return false;
}

void count_particles(const std::filesystem::path& log, ResamplingScore& score) {
  LogReader reader(log.string());
  int messages = 0;
  while (const auto event = reader.next_view()) {
    if (event->channel != "FASTSLAM_PARTICLES") continue;
    const auto m = decode_message<particles_t>(event->data, event->size);
    std::set<std::array<float, 7>> distinct;
    for (const particle_t& p : m.particles)
      distinct.insert({p.trans[0], p.trans[1], p.trans[2], p.quat[0], p.quat[1], p.quat[2], p.quat[3]});
    score.distinct += static_cast<double>(distinct.size());
    score.effective_sample_size += static_cast<double>(m.effective_sample_size);
    ++messages;
  }
  score.distinct /= std::max(1, messages);
  score.effective_sample_size /= std::max(1, messages);
}

}  // namespace

std::vector<ResamplingScore> study_resampling(const ResamplingStudySettings& settings,
                                              const std::filesystem::path& folder) {
  const Trajectory truth = robot_truth(settings.log.string());
  const std::filesystem::path features =
      has_features(settings.log)
          ? settings.log
          : run(settings, settings.log, folder / "features", {"launch.processes=[surf, odometry]"});
  EvaluationSettings evaluation;
  evaluation.association = Association::interpolate_truth;
  std::vector<ResamplingScore> scores;
  for (const char* preset : {"thesis", "modern"})
    for (const char* scheme : {"multinomial", "systematic", "stratified", "residual"})
      for (const int seed : settings.seeds) {
        ResamplingScore score;
        score.preset = preset;
        score.scheme = scheme;
        score.seed = seed;
        const auto result =
            run(settings, features, folder / "run",
                {"launch.processes=[fastslam]", std::string("fastslam.preset=") + preset,
                 std::string("fastslam.resampling=") + scheme, "fastslam.seed=" + std::to_string(seed)});
        const PoseLog poses = read_pose_log(result.string());
        const PoseChannel& path = poses.channel("FASTSLAM_POSE", result.string());
        const bool just_begun = path.restarts > 0 && path.trajectory.size() < 3;
        score.ate = just_begun ? std::nan("")
                               : evaluate(truth, path.trajectory, evaluation).absolute.translation.rmse;
        score.lost = path.lost + path.earlier_lost;
        score.restarts = path.restarts;
        count_particles(result, score);
        scores.push_back(score);
      }
  return scores;
}

std::string resampling_table(const std::vector<ResamplingScore>& scores) {
  Table table({"preset", "scheme", "seeds", "ATE median m", "worst m", "distinct particles", "ESS", "lost",
               "new maps"});
  std::size_t broken = 0;
  for (std::size_t begin = 0; begin < scores.size();) {
    std::size_t end = begin;
    std::vector<double> ate;
    double distinct = 0, sample_size = 0;
    int lost = 0, restarts = 0;
    for (; end < scores.size() && scores[end].preset == scores[begin].preset &&
           scores[end].scheme == scores[begin].scheme;
         ++end) {
      if (scores[end].restarts == 0) ate.push_back(scores[end].ate);
      broken += scores[end].restarts > 0 ? 1 : 0;
      lost += scores[end].lost;
      restarts += scores[end].restarts;
      distinct += scores[end].distinct;
      sample_size += scores[end].effective_sample_size;
    }
    const auto n = static_cast<double>(end - begin);
    table.add({scores[begin].preset, scores[begin].scheme, std::to_string(end - begin),
               fixed_number(median(ate), 4),
               ate.empty() ? "-" : fixed_number(*std::max_element(ate.begin(), ate.end()), 4),
               fixed_number(distinct / n, 1), fixed_number(sample_size / n, 1), std::to_string(lost),
               std::to_string(restarts)});
    begin = end;
  }
  return table.text() + new_maps_text(broken, scores.size());
}

nlohmann::json resampling_json(const std::vector<ResamplingScore>& scores) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ResamplingScore& s : scores)
    rows.push_back({{"preset", s.preset},
                    {"scheme", s.scheme},
                    {"seed", s.seed},
                    {"ate_m", s.ate},
                    {"distinct_particles", s.distinct},
                    {"effective_sample_size", s.effective_sample_size},
                    {"lost", s.lost},
                    {"restarts", s.restarts}});
  return {{"runs", rows}};
}

}  // namespace lcmslam

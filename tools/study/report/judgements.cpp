#include "tools/study/report/judgements.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "tools/study/consistency_study.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

std::string ratio_name(const AlternationRatio& ratio) {
  if (ratio.surf == 0) return "the cloud alone";
  if (ratio.cloud == 0) return "SURF alone";
  return fmt::format("{}:{}", ratio.cloud, ratio.surf);
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

/// Infinite: only the first one is lost. NaN: the other one is, and nothing can be told.
double times_as_wrong(const std::vector<double>& one, const std::vector<double>& other) {
  const double divisor = median_or_lost(other);
  return std::isfinite(divisor) ? median_or_lost(one) / divisor : std::nan("");
}

std::string times_in_words(double times, const std::string& one, const std::string& other) {
  if (std::isinf(times)) return one + " is lost and " + other + " is not";
  return fmt::format("{} errs {:.1f} times as much as {}", one, times, other);
}

}  // namespace

Judgement judge_alternation(const std::vector<AlternationRatio>& ratios, std::size_t pairs) {
  std::size_t plain = 0, surf_alone = 0, best = 0, best_turns = 0;
  for (const AlternationRatio& ratio : ratios) {
    std::size_t& of_kind = ratio.surf == 0 ? plain : ratio.cloud == 0 ? surf_alone : best_turns;
    of_kind = std::max(of_kind, ratio.right);
    best = std::max(best, ratio.right);
  }
  std::vector<std::string> names, rising;
  for (const AlternationRatio& ratio : ratios) {
    if (ratio.right == best) names.push_back(ratio_name(ratio));
    if (ratio.surf > 0 && ratio.cloud > 0 && ratio.rising > 0)
      rising.push_back(fmt::format("{:.0f} % at {}", 100 * ratio.rising, ratio_name(ratio)));
  }
  Judgement judgement;
  if (best_turns > plain)
    judgement.agreement = best_turns > surf_alone ? Agreement::agrees : Agreement::agrees_in_part;
  judgement.finding = fmt::format(
      "At 4 cm {} {} right most often, in {} of {} pairs; turns between both in {} at best, the cloud "
      "alone in {}, SURF alone in {}. {}",
      listed(names), names.size() == 1 ? "is" : "are", best, pairs, best_turns, plain, surf_alone,
      rising.empty() ? "In half of the pairs the cloud's error never rises again: no oscillation."
                     : "The cloud's error rises again, which is the oscillation, in " + listed(rising) +
                           " of the rounds (median).");
  return judgement;
}

bool follows_chi_square(double statistic, double freedom) {
  constexpr double normal_quantile = 3.2905;  // 99.95 %
  return statistic > chi_square_quantile(freedom, -normal_quantile) &&
         statistic < chi_square_quantile(freedom, normal_quantile);
}

Judgement judge_weak_cases(const std::vector<WeakErrors>& bare, const WeakErrors& dark) {
  constexpr double failure = 2;
  double worst = 0;
  std::vector<std::string> unknown;
  for (const WeakErrors& errors : bare) {
    const double times = times_as_wrong(errors.icp, errors.filter);
    if (std::isnan(times))
      unknown.push_back(errors.name);
    else
      worst = std::max(worst, times);
  }
  const double without_light = times_as_wrong(dark.filter, dark.icp);
  if (std::isnan(without_light)) unknown.push_back(dark.name);
  const bool icp_fails = worst > failure, filter_fails = without_light > failure;
  Judgement judgement;
  judgement.agreement = icp_fails && filter_fails   ? Agreement::agrees
                        : icp_fails || filter_fails ? Agreement::agrees_in_part
                                                    : Agreement::differs;
  judgement.finding =
      "With little geometry " +
      (worst > 0 ? times_in_words(worst, "the thesis's ICP", "its FastSLAM") + " at the worst, which " +
                       (icp_fails ? "is" : "is not yet") + " what figure 4.2 shows"
                 : std::string("nothing can be told")) +
      "; without light " +
      (std::isnan(without_light) ? "nothing can be told"
                                 : times_in_words(without_light, "FastSLAM", "ICP") + ", " +
                                       (filter_fails ? "the opposite" : "which is no failure of its own")) +
      ".";
  if (!unknown.empty())
    judgement.finding += " Whom the other one is measured by is lost itself: " + listed(unknown) + ".";
  return judgement;
}

std::string worst_with_person(const std::vector<PersonErrors>& mappers) {
  std::string worst, lost_alone;
  double most = 0;
  for (const PersonErrors& mapper : mappers) {
    const double times = times_as_wrong(mapper.with, mapper.alone);
    if (std::isnan(times)) lost_alone += "; " + mapper.mapper + " is lost without her, too";
    if (!(times > most)) continue;
    most = times;
    worst = mapper.mapper + " suffers most, " +
            (std::isinf(times) ? "it is lost" : fmt::format("{:.1f} times its error alone", times));
  }
  return (worst.empty() ? "who suffers most is not known" : worst) + lost_alone;
}

}  // namespace lcmslam

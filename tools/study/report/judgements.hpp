#pragma once
// What findings may say of the figures that experiments found.

#include <string>
#include <vector>

#include "tools/study/report/experiment.hpp"

namespace lcmslam {

struct Judgement {
  Agreement agreement = Agreement::differs;
  std::string finding;
};

/// Registrations with so many iterations by the cloud and then by SURF's points, in turns.
struct AlternationRatio {
  int cloud = 1, surf = 0;
  std::size_t right = 0;  ///< of the pairs
  double rising = 0;      ///< median share of the rounds in which the cloud's error rises; NaN: none
};
/// Agrees where turns between both are right more often than the cloud alone, in part where SURF alone is as
/// often.
Judgement judge_alternation(const std::vector<AlternationRatio>& ratios, std::size_t pairs);

/// Whether chi-square of so many degrees of freedom is no more than chance: both tails together hold 0.1 %.
bool follows_chi_square(double statistic, double freedom);

/// The thesis's errors in a case where one mapper should fail, m, of each seed; NaN: lost.
struct WeakErrors {
  std::string name;
  std::vector<double> filter, icp;
};
/// `bare`: where there is little geometry, in which ICP should fail; `dark`: where FastSLAM should.
Judgement judge_weak_cases(const std::vector<WeakErrors>& bare, const WeakErrors& dark);

/// A mapper's errors alone and with a person before the robot, m, of each seed; NaN: lost.
struct PersonErrors {
  std::string mapper;
  std::vector<double> alone, with;
};
/// Who suffers most from her, in words.
std::string worst_with_person(const std::vector<PersonErrors>& mappers);

}  // namespace lcmslam

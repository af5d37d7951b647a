#pragma once
// What an experiment of the study is, and what it tells: numbers with their units, and one sentence. How that
// looks is the report's business (study_page.hpp); every number that is shown stands in the JSON.

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace lcmslam {

struct ChartAxis {
  std::string label;                    ///< "rotation offset"
  std::string unit;                     ///< "deg"; empty: a count or a ratio
  bool logarithmic = false;             ///< for values that span decades
  std::vector<std::string> names = {};  ///< what 1, 2, ... are along x; empty: the values are numbers
};

/// A curve, a cloud of points or a row of bars. `x`, `y` of one length, in their axes' units.
struct ChartSeries {
  enum class Mark { line, dots, bars, ellipse_outline };
  std::string name;
  Mark mark = Mark::line;
  std::vector<double> x, y;
  std::vector<double> low, high;  ///< spread of y over seeds, of the same length; empty: not shown
};

struct Chart {
  std::string title;
  ChartAxis x, y;
  std::vector<ChartSeries> series;
  bool equal_scales = false;  ///< a metre is as long in x as in y: maps and paths
};

/// values[row][column]; NaN: not measured.
struct HeatMap {
  std::string title;
  ChartAxis x, y, value;
  std::vector<double> columns, rows;  ///< along x and along y
  std::vector<std::vector<double>> values;
};

/// An image beside the report's numbers: maps, masks, features in an image. PNG or JPEG, stored in the page
/// itself.
struct Picture {
  std::string title;
  std::string text;  ///< what is seen, for whoever cannot see it
  std::filesystem::path file;
};

/// Cells are numbers, or words such as the name of a method or "holds". Columns name their units.
struct ResultTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<nlohmann::json>> rows;
};

/// What was found, held against the thesis.
enum class Agreement { agrees, agrees_in_part, differs, beyond };

struct ExperimentResult {
  std::string finding;                      ///< one sentence with the numbers that carry it
  Agreement agreement = Agreement::beyond;  ///< beyond: the thesis says nothing about it
  std::vector<int> seeds;                   ///< that the spread is over
  nlohmann::json settings;                  ///< of this experiment: offsets, noise, presets, scenes
  std::vector<Chart> charts;
  std::vector<HeatMap> heat_maps;
  std::vector<Picture> pictures;
  std::vector<ResultTable> tables;
  nlohmann::json timing = nlohmann::json::object();  ///< seconds; these two may differ from run to run
  nlohmann::json memory = nlohmann::json::object();  ///< bytes
};

struct StudyContext {
  bool quick = false;                                    ///< a few seeds and pairs, for the tests
  std::vector<int> seeds;                                ///< of sensors, particles and offsets
  std::filesystem::path work;                            ///< an empty folder for logs and pictures
  std::filesystem::path data;                            ///< of real recordings; empty where there are none
  std::function<void(double)> progress = [](double) {};  ///< 0 to 1 of this experiment
};

struct Experiment {
  std::string name;    ///< for --only: "convergence"
  std::string title;   ///< "Convergence without an initial alignment"
  std::string thesis;  ///< "figures 3.8 to 3.11"; empty: beyond it
  std::function<ExperimentResult(const StudyContext&)> run;
};

/// In the thesis's order; each room of experiments adds its own (report/*_experiments.cpp).
std::vector<Experiment> mapping_experiments();
std::vector<Experiment> registration_experiments();

}  // namespace lcmslam

#include "tools/study/report/study_json.hpp"

#include <stdexcept>

#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

const char* name_of(ChartSeries::Mark mark) {
  switch (mark) {
    case ChartSeries::Mark::line:
      return "line";
    case ChartSeries::Mark::dots:
      return "dots";
    case ChartSeries::Mark::bars:
      return "bars";
    case ChartSeries::Mark::ellipse_outline:
      return "ellipse_outline";
  }
  throw std::logic_error("a mark without a name");
}

nlohmann::json numbers(const std::vector<double>& values) {
  nlohmann::json json = nlohmann::json::array();
  for (const double value : values) json.push_back(number(value));
  return json;
}

nlohmann::json axis_json(const ChartAxis& axis) {
  return {
      {"label", axis.label}, {"unit", axis.unit}, {"logarithmic", axis.logarithmic}, {"names", axis.names}};
}

nlohmann::json series_json(const ChartSeries& series) {
  const std::size_t n = series.x.size(), low = series.low.size(), high = series.high.size();
  if (series.y.size() != n || low != high || (low != 0 && low != n))
    throw std::invalid_argument("series '" + series.name + "': x, y, low and high differ in length");
  return {{"name", series.name},    {"mark", name_of(series.mark)}, {"x", numbers(series.x)},
          {"y", numbers(series.y)}, {"low", numbers(series.low)},   {"high", numbers(series.high)}};
}

nlohmann::json chart_json(const Chart& chart) {
  nlohmann::json series = nlohmann::json::array();
  for (const ChartSeries& one : chart.series) series.push_back(series_json(one));
  return {{"title", chart.title},
          {"x", axis_json(chart.x)},
          {"y", axis_json(chart.y)},
          {"equal_scales", chart.equal_scales},
          {"series", series}};
}

nlohmann::json heat_map_json(const HeatMap& map) {
  nlohmann::json values = nlohmann::json::array();
  for (const auto& row : map.values) {
    if (row.size() != map.columns.size()) values = nullptr;
    if (values.is_null()) break;
    values.push_back(numbers(row));
  }
  if (map.values.size() != map.rows.size() || values.is_null())
    throw std::invalid_argument("heat map '" + map.title + "': its values are not rows x columns");
  return {{"title", map.title},
          {"x", axis_json(map.x)},
          {"y", axis_json(map.y)},
          {"value", axis_json(map.value)},
          {"columns", numbers(map.columns)},
          {"rows", numbers(map.rows)},
          {"values", values}};
}

nlohmann::json table_json(const ResultTable& table) {
  for (const auto& row : table.rows)
    if (row.size() != table.columns.size())
      throw std::invalid_argument("table '" + table.title + "': a row is not as long as the columns");
  return {{"title", table.title}, {"columns", table.columns}, {"rows", rounded(table.rows)}};
}

template <typename Part>
nlohmann::json list_of(const std::vector<Part>& parts, nlohmann::json (*json_of)(const Part&)) {
  nlohmann::json list = nlohmann::json::array();
  for (const Part& part : parts) list.push_back(json_of(part));
  return list;
}

nlohmann::json picture_json(const Picture& picture) {
  return {{"title", picture.title}, {"text", picture.text}, {"file", picture.file.filename().string()}};
}

}  // namespace

const char* words_for(Agreement agreement) {
  switch (agreement) {
    case Agreement::agrees:
      return "agrees";
    case Agreement::agrees_in_part:
      return "agrees in part";
    case Agreement::differs:
      return "differs";
    case Agreement::beyond:
      return "beyond the thesis";
  }
  throw std::logic_error("an agreement without words");
}

nlohmann::json rounded(const nlohmann::json& value) {
  if (value.is_number_float()) return number(value.get<double>());
  nlohmann::json copy = value;
  if (value.is_structured())
    for (auto& part : copy) part = rounded(part);
  return copy;
}

nlohmann::json experiment_json(const ExperimentResult& result) {
  return {{"finding", result.finding},
          {"agreement", words_for(result.agreement)},
          {"seeds", result.seeds},
          {"settings", rounded(result.settings)},
          {"charts", list_of(result.charts, chart_json)},
          {"heat_maps", list_of(result.heat_maps, heat_map_json)},
          {"tables", list_of(result.tables, table_json)},
          {"pictures", list_of(result.pictures, picture_json)},
          {"timing", rounded(result.timing)},
          {"memory", rounded(result.memory)}};
}

}  // namespace lcmslam

#pragma once
#include <string>

namespace lcmslam {

/// A YAML scalar that reads back as exactly this text, whatever is in it: for paths in overrides, where a
/// blank and a '#' would begin a comment and a line's end would become a blank.
std::string yaml_quoted(const std::string& text);

}  // namespace lcmslam

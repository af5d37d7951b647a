#pragma once
// Numbers in files that others read: with a decimal point, whatever the locale of the process. printf and
// streams write the comma of a host that has set its own.

#include <string>

namespace lcmslam {

/// As "%.*f" does in the C locale.
void append_fixed(std::string& text, double number, int decimals);

/// As "%.*g" does in the C locale.
void append_general(std::string& text, double number, int digits);

}  // namespace lcmslam

# Run by ctest: lcmslam_add_suites(PROGRAM PREFIX COST [LABEL...]) makes a test of each suite of a GoogleTest program. What
# its cases share is then made once, and programs start some hundred times, not thousands. The higher the COST, the earlier
# ctest begins them. Cases that LCMSLAM_WITHOUT_CASES names in the environment (patterns with colons between) are left out.
function(lcmslam_add_suites program prefix cost)
  set(list "")
  if(EXISTS ${program})
    execute_process(COMMAND ${program} --gtest_list_tests OUTPUT_VARIABLE list ERROR_QUIET)
  endif()
  string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\." suites "${list}")
  if(NOT suites)  # not built, or unable to start: a test that fails
    add_test(${prefix} ${program})
    return()
  endif()
  set(without "")
  if(DEFINED ENV{LCMSLAM_WITHOUT_CASES})
    set(without "-$ENV{LCMSLAM_WITHOUT_CASES}")
  endif()
  foreach(suite IN LISTS suites)
    string(REGEX REPLACE "[\n.]" "" suite ${suite})
    add_test(${prefix}.${suite} ${program} --gtest_filter=${suite}.*${without})
    # Skipped is a suite of which all was skipped and nothing failed: the output ends with what was skipped.
    set_tests_properties(${prefix}.${suite} PROPERTIES TIMEOUT 1500 COST ${cost} LABELS "${ARGN}" SKIP_REGULAR_EXPRESSION
      "\\[  PASSED  \\] 0 tests\\.\n(\\[  SKIPPED \\][^\n]*\n?)+$")
  endforeach()
endfunction()

# One place for what all of our targets share: warnings, sanitizers, include root.
add_library(lcmslam_options INTERFACE)
# Headers are <lcmslam/surf/surf.hpp> in the tree and after install alike: a link stands for the prefix. What is
# not installed has the tree as its root: "procs/surf/surf_node.hpp".
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/include)
file(CREATE_LINK ${CMAKE_SOURCE_DIR}/libs ${CMAKE_BINARY_DIR}/include/lcmslam SYMBOLIC)
target_compile_options(lcmslam_options INTERFACE -Wall -Wextra -Wconversion
                       $<IF:$<BOOL:$<TARGET_PROPERTY:LCMSLAM_SHADOW_LOCAL>>,-Wshadow=local,-Wshadow>)
if(NOT LCMSLAM_SANITIZE)  # with sanitizers GCC 12 warns of what is not so, in std::regex for one
  target_compile_options(lcmslam_options INTERFACE -Werror)
endif()
# Identical floating-point results whatever the compiler fuses: batch runs are compared byte for byte.
target_compile_options(lcmslam_options INTERFACE -ffp-contract=off)
# Messages that name a source file name it from the root of the tree, wherever that stood; ccache names files from the
# folder of the build.
file(RELATIVE_PATH source_from_build ${CMAKE_BINARY_DIR} ${CMAKE_SOURCE_DIR}/)
target_compile_options(lcmslam_options INTERFACE -fmacro-prefix-map=${CMAKE_SOURCE_DIR}/= -fmacro-prefix-map=${source_from_build}=)
# A static library names everything that one of its files may need; a program loads what it does need.
target_link_options(lcmslam_options INTERFACE -Wl,--as-needed)
if(LCMSLAM_SANITIZE)
  # Eigen in our files allocates as it does in Ceres, which is not instrumented: what one allocates the other may free.
  target_compile_definitions(lcmslam_options INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  # Not vptr: with it LCM 1.3.1's own header hands a wrong pointer to its first callback.
  target_compile_options(lcmslam_options INTERFACE -fsanitize=address,undefined -fno-sanitize=vptr
                                                   -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  if(NOT LCMSLAM_FUZZ)
    # Checks of each reference are half of the compilation: what reads through a null pointer ends anyway, and what reads
    # bytes from outside is looked at by the fuzzers, with all checks.
    target_compile_options(lcmslam_options INTERFACE -fno-sanitize=null,alignment)
  endif()
  target_link_options(lcmslam_options INTERFACE -fsanitize=address,undefined)
endif()
if(LCMSLAM_FUZZ)
  target_compile_options(lcmslam_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# lcmslam_precompile(TARGET HEADER... | REUSE_FROM OTHER): other people's headers, read once for all files of the
# target. Files still include what they use; the debug preset builds without.
function(lcmslam_precompile target)
  if(LCMSLAM_PRECOMPILE)
    if(ARGV1 STREQUAL REUSE_FROM)
      target_precompile_headers(${target} ${ARGN})
    else()
      target_precompile_headers(${target} PRIVATE ${ARGN})
    endif()
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # For ccache; and memory is there to do without the compiler's garbage collection, 7 % of its time.
      target_compile_options(${target} PRIVATE -fpch-preprocess --param=ggc-min-heapsize=1000000)
    endif()
  endif()
endfunction()

# lcmslam_batch(TARGET [SIZE n] [ALONE file.cpp ...]): with LCMSLAM_UNITY the compiler takes 24 files at a time, or n, so
# that what they share is read and made once. Vectorised files have options of their own and stay apart.
function(lcmslam_batch target)
  cmake_parse_arguments(ARG "" "SIZE" "ALONE" ${ARGN})
  if(LCMSLAM_UNITY)
    if(NOT ARG_SIZE)
      set(ARG_SIZE 24)
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ARG_SIZE})
    set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# What nearly every file of libs and procs reads: once for all of them.
file(WRITE ${CMAKE_BINARY_DIR}/precompiled.cpp "")
add_library(lcmslam_precompiled STATIC ${CMAKE_BINARY_DIR}/precompiled.cpp)
target_link_libraries(lcmslam_precompiled PRIVATE lcmslam_options Eigen3::Eigen opencv_core)
lcmslam_precompile(lcmslam_precompiled <Eigen/Dense> <opencv2/core.hpp> <algorithm> <array> <chrono> <cmath> <cstdint>
                   <deque> <filesystem> <fstream> <functional> <future> <iostream> <limits> <map> <memory> <numeric>
                   <optional> <set> <sstream> <stdexcept> <string> <thread> <tuple> <utility> <vector>)

# lcmslam_library(surf DEPENDS lcmslam_parallel opencv_core ... PRIVATE pcl_io ... HEADERS Eigen3::Eigen
#                 SUBFOLDERS landmarks ... ALONE landmark_lanes.cpp ... [INTERNAL])
# makes lcmslam_surf from every .cpp of the current folder and of SUBFOLDERS; installed, it is lcmslam::surf. PRIVATE:
# libraries that only its .cpp files see (PCL's compile flags and headers are heavy). HEADERS: the same, but nothing to
# link, so that who uses the library need not have them. ALONE: files whose local names other files have too, kept out
# of batches (lcmslam_batch). INTERNAL: not installed.
function(lcmslam_library name)
  cmake_parse_arguments(ARG "INTERNAL" "" "DEPENDS;PRIVATE;HEADERS;SUBFOLDERS;ALONE" ${ARGN})
  lcmslam_require(${ARG_DEPENDS} ${ARG_PRIVATE} ${ARG_HEADERS})
  set(patterns ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  foreach(folder ${ARG_SUBFOLDERS})
    list(APPEND patterns ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  endforeach()
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/main.cpp)
  add_library(lcmslam_${name} STATIC ${sources})
  target_include_directories(lcmslam_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/include>
                                                    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(lcmslam_${name} PUBLIC ${ARG_DEPENDS} PRIVATE $<BUILD_INTERFACE:lcmslam_options> ${ARG_PRIVATE})
  foreach(item ${ARG_HEADERS})
    target_link_libraries(lcmslam_${name} PRIVATE $<BUILD_INTERFACE:${item}>)
  endforeach()
  lcmslam_precompile(lcmslam_${name} REUSE_FROM lcmslam_precompiled)
  lcmslam_batch(lcmslam_${name} ALONE ${ARG_ALONE})
  if(NOT ARG_INTERNAL)
    lcmslam_install_library(${name} LINKS ${ARG_DEPENDS} ${ARG_PRIVATE})
  endif()
endfunction()

# lcmslam_vectorise(FILE... [OPTIONS -f...]): row loops that the compiler vectorises at -O3; the sanitizer and debug
# presets keep their own level, but there too these files stay out of batches. No exception flags of floating point are
# looked at: without them comparisons vectorise too; results keep their bits.
function(lcmslam_vectorise)
  cmake_parse_arguments(ARG "" "" "OPTIONS" ${ARGN})
  set_source_files_properties(${ARG_UNPARSED_ARGUMENTS} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(NOT CMAKE_BUILD_TYPE STREQUAL "Debug" AND NOT LCMSLAM_SANITIZE)
    set_source_files_properties(${ARG_UNPARSED_ARGUMENTS} PROPERTIES COMPILE_OPTIONS "-O3;-fno-trapping-math;${ARG_OPTIONS}")
    if(ARG_OPTIONS)
      set_source_files_properties(${ARG_UNPARSED_ARGUMENTS} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    endif()
  endif()
endfunction()

# lcmslam_process(surf DEPENDS ... [ALONE ...]): procs/surf/{*_node.cpp,main.cpp} -> library lcmslam_surf_node, program
# lcmslam-surf.
function(lcmslam_process name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;ALONE" ${ARGN})
  lcmslam_library(${name}_node INTERNAL DEPENDS lcmslam_messages lcmslam_runtime ${ARG_DEPENDS} ALONE ${ARG_ALONE})
  target_include_directories(lcmslam_${name}_node PUBLIC ${CMAKE_SOURCE_DIR})
  add_executable(lcmslam-${name} main.cpp)
  target_link_libraries(lcmslam-${name} PRIVATE lcmslam_options lcmslam_${name}_node)
  install(TARGETS lcmslam-${name} COMPONENT runtime)
endfunction()

# The same for tests.
function(lcmslam_precompile_tests)
  add_library(lcmslam_precompiled_tests STATIC ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(lcmslam_precompiled_tests PRIVATE lcmslam_options Eigen3::Eigen opencv_core GTest::gmock)
  target_compile_options(lcmslam_precompiled_tests PRIVATE $<$<CONFIG:Release>:-O1>)
  lcmslam_precompile(lcmslam_precompiled_tests <gmock/gmock.h> <Eigen/Dense> <opencv2/core.hpp> <algorithm> <cmath>
                     <filesystem> <fstream> <limits> <map> <memory> <optional> <set> <sstream> <string> <vector>)
endfunction()

# lcmslam_test(surf DEPENDS ... [FOLDER folder] [COST seconds] [LABELS ...]): every .cpp of tests/unit/surf -> test_surf,
# whose suites ctest knows.
function(lcmslam_test name)
  cmake_parse_arguments(ARG "" "FOLDER;COST" "DEPENDS;LABELS" ${ARGN})
  if(NOT ARG_COST)
    set(ARG_COST 1)
  endif()
  if(NOT ARG_FOLDER)
    set(ARG_FOLDER ${CMAKE_CURRENT_SOURCE_DIR}/${name})
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${ARG_FOLDER}/*.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE lcmslam_options lcmslam_test_support ${ARG_DEPENDS} Eigen3::Eigen GTest::gmock
                                            GTest::gtest_main)
  target_compile_options(test_${name} PRIVATE $<$<CONFIG:Release>:-O1>)  # they are built more often than run
  lcmslam_precompile(test_${name} REUSE_FROM lcmslam_precompiled_tests)
  lcmslam_batch(test_${name} SIZE 8)  # whose local names meet more often
  # A local name may be that of a helper in another file of the batch.
  set_target_properties(test_${name} PROPERTIES LCMSLAM_SHADOW_LOCAL "${LCMSLAM_UNITY}")
  target_include_directories(test_${name} PRIVATE ${CMAKE_SOURCE_DIR})
  set(suites ${CMAKE_CURRENT_BINARY_DIR}/test_${name}_suites.cmake)
  file(GENERATE OUTPUT ${suites} CONTENT
       "include(\"${CMAKE_SOURCE_DIR}/cmake/LcmSlamTestSuites.cmake\")
lcmslam_add_suites(\"$<TARGET_FILE:test_${name}>\" ${name} ${ARG_COST} ${ARG_LABELS})\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${suites})
endfunction()

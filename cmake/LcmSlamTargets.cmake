# One place for what all of our targets share: warnings, sanitizers, include root.
add_library(lcmslam_options INTERFACE)
target_include_directories(lcmslam_options INTERFACE ${CMAKE_SOURCE_DIR}/libs)
target_compile_options(lcmslam_options INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror)
# Identical floating-point results whatever the compiler fuses: batch runs are compared byte for byte.
target_compile_options(lcmslam_options INTERFACE -ffp-contract=off)
# A static library names everything that one of its files may need; a program loads what it does need.
target_link_options(lcmslam_options INTERFACE -Wl,--as-needed)
if(LCMSLAM_SANITIZE)
  # Not vptr: with it LCM 1.3.1's own header hands a wrong pointer to its first callback.
  target_compile_options(lcmslam_options INTERFACE -fsanitize=address,undefined -fno-sanitize=vptr
                                                   -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(lcmslam_options INTERFACE -fsanitize=address,undefined)
endif()
if(LCMSLAM_FUZZ)
  target_compile_options(lcmslam_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# lcmslam_precompile(TARGET HEADER...): other people's headers, read once for all files of the target. Files
# still include what they use; the debug preset builds without.
function(lcmslam_precompile target)
  if(LCMSLAM_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE ${ARGN})
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # For ccache; and memory is there to do without the compiler's garbage collection, 7 % of its time.
      target_compile_options(${target} PRIVATE -fpch-preprocess --param=ggc-min-heapsize=1000000)
    endif()
  endif()
endfunction()

# lcmslam_library(surf DEPENDS lcmslam_geometry opencv_core ... PRIVATE pcl_io ...)
# makes lcmslam_surf from every .cpp of the current folder. PRIVATE: libraries that only its .cpp files
# see (PCL's compile flags and headers are heavy).
function(lcmslam_library name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/main.cpp)
  add_library(lcmslam_${name} STATIC ${sources})
  target_link_libraries(lcmslam_${name} PUBLIC lcmslam_options ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
endfunction()

# lcmslam_process(surf DEPENDS ...): procs/surf/{*_node.cpp,main.cpp} -> library lcmslam_surf_node, program lcmslam-surf.
function(lcmslam_process name)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  lcmslam_library(${name}_node DEPENDS lcmslam_messages lcmslam_runtime ${ARG_DEPENDS})
  target_include_directories(lcmslam_${name}_node PUBLIC ${CMAKE_SOURCE_DIR}/procs)
  add_executable(lcmslam-${name} main.cpp)
  target_link_libraries(lcmslam-${name} PRIVATE lcmslam_${name}_node)
endfunction()

# lcmslam_test(surf DEPENDS ...): every .cpp of tests/unit/surf -> test_surf, known to ctest.
function(lcmslam_test name)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE ${ARG_DEPENDS} Eigen3::Eigen GTest::gmock GTest::gtest_main)
  target_compile_definitions(test_${name} PRIVATE LCMSLAM_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  target_compile_options(test_${name} PRIVATE $<$<CONFIG:Release>:-O1>)  # they are built more often than run
  lcmslam_precompile(test_${name} <gmock/gmock.h> <Eigen/Dense>)
  target_include_directories(test_${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60
                       PROPERTIES TIMEOUT 300)
endfunction()
include(GoogleTest)

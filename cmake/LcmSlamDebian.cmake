# `cpack` in a build folder makes the Debian packages lcmslam (programs and data), lcmslam-dev (libraries, headers, CMake
# package) and lcmslam-spy (views for lcm-spy).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The lcmslam authors")
set(CPACK_PACKAGE_CONTACT "The lcmslam authors <maintainers@lcmslam.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development)
if(TARGET lcmslam_spy_jar)
  list(APPEND CPACK_COMPONENTS_ALL spy)
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME lcmslam)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "iproute2, liblcm-bin")  # lcm-logger and its like
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "lcmslam-spy, mosquitto, python3-numpy, python3-pil")  # share/lcmslam/python
set(scripts ${CMAKE_BINARY_DIR}/package/systemd)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${scripts}/postinst ${scripts}/prerm ${scripts}/postrm)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "maps from colour, depth and wheels with two SLAM methods
FastSLAM over SURF landmarks and 6-D SLAM by registration run side by
side on LCM messages. `lcmslam demo` drives a simulated robot through a
kitchen and shows both maps.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME lcmslam-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libeigen3-dev, libopencv-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "libbz2-dev, libceres-dev, libcli11-dev, libdeflate-dev, libembree-dev, liblcm-dev, \
liboctomap-dev, libpcl-dev, libsodium-dev, libspdlog-dev, libsqlite3-dev, libturbojpeg0-dev, libyaml-cpp-dev, libzstd-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "libraries of lcmslam to link
SURF, registration, FastSLAM's landmark filters and more as static
libraries with headers: find_package(lcmslam COMPONENTS surf). The
suggested packages are each needed by some of the components only.")

set(CPACK_DEBIAN_SPY_PACKAGE_NAME lcmslam-spy)
set(CPACK_DEBIAN_SPY_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SPY_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_SPY_PACKAGE_DEPENDS
    "lcmslam (>= ${PROJECT_VERSION}), default-jre, liblcm-java, libjchart2d-java")
set(CPACK_COMPONENT_SPY_DESCRIPTION "views of lcmslam's messages for lcm-spy
`lcmslam lcm-spy` starts the stock program with the message types, the
camera's images and the paths of both mappers.")

# What every Debian package has: copyright and changelog.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(component runtime development spy)
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(changelog ${CMAKE_BINARY_DIR}/package/${package}/changelog)
  file(WRITE ${changelog} "lcmslam (${PROJECT_VERSION}) bookworm; urgency=medium\n\n  * See CHANGELOG.md of the source.\n\n \
-- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  execute_process(COMMAND gzip -9nf ${changelog} COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${changelog}.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} RENAME copyright COMPONENT ${component})
endforeach()
include(CPack)

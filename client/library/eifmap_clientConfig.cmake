find_package(lcm CONFIG QUIET)
if(NOT TARGET lcm::lcm)  # LCM before 1.4 ships no CMake package
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(LCM REQUIRED IMPORTED_TARGET lcm)
  add_library(lcm::lcm ALIAS PkgConfig::LCM)
endif()
include(${CMAKE_CURRENT_LIST_DIR}/eifmap_client.cmake)

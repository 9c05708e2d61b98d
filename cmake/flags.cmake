# Flags that every target shares. Sums may be reassociated (neighbour loops vectorise), but never by the alignment of an address: the same
# program gives the same bits in every run, with any number of threads. NaN and infinity keep their meaning: divergence is detected by them.
add_library(whorl_flags INTERFACE)
target_compile_options(whorl_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wno-unknown-pragmas
  -fno-math-errno -fno-trapping-math -fno-signed-zeros -fassociative-math)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # The warnings that are off: GCC 12's false alarms inside std::string ("text" + string&&, GCC bug 105329), std::optional and its own AVX-512 header
  # (a precompiled header makes it report them in our files); asan looks in their place.
  target_compile_options(whorl_flags INTERFACE --param=vect-max-peeling-for-alignment=0 -Wno-maybe-uninitialized -Wno-restrict -Wno-stringop-overflow
                         -Wno-stringop-overread -Wno-array-bounds -Wno-uninitialized)
endif()
if(WHORL_NATIVE)
  target_compile_options(whorl_flags INTERFACE -march=native)
else()  # what is given away names no folder of the machine that built it
  target_compile_options(whorl_flags INTERFACE -fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=)
endif()
if(WHORL_WERROR)
  target_compile_options(whorl_flags INTERFACE -Werror)
endif()
if(WHORL_DOUBLE)
  target_compile_definitions(whorl_flags INTERFACE WHORL_DOUBLE)
endif()
if(WHORL_SANITIZE)
  # The vectors of the viscous product are not inlined then, and how gcc returns them depends on the target: which is one for the whole build.
  target_compile_options(whorl_flags INTERFACE -fsanitize=${WHORL_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1
                         -Wno-psabi)
  target_link_options(whorl_flags INTERFACE -fsanitize=${WHORL_SANITIZE})
endif()
# What computes nothing to speak of (reading scenes, the command line, tests) is optimised little: that halves its compile time. A target says so
# by the property WHORL_COLD.
if(NOT CMAKE_BUILD_TYPE STREQUAL "Debug" AND NOT WHORL_SANITIZE)
  target_compile_options(whorl_flags INTERFACE $<IF:$<BOOL:$<TARGET_PROPERTY:WHORL_COLD>>,-O1,-O3>)
endif()

# What nearly every source includes, compiled once for a target (two fifths of its compile time), with what else most of the target's sources include.
function(precompile_headers target)
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  target_precompile_headers(${target} PRIVATE <Eigen/Core> <Eigen/Geometry> <algorithm> <cmath> <filesystem> <functional> <map> <memory> <optional>
                            <string> <variant> <vector> <fmt/format.h> ${ARGN})
endfunction()

# Where CMAKE_UNITY_BUILD is on (the presets), the sources of a folder are compiled as one: their headers are read once. So names in unnamed
# namespaces are unique within a folder.
function(unity_by_folder target)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(source MATCHES "\\.cpp$")
      file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${source})
      get_filename_component(folder ${path} DIRECTORY)
      string(REPLACE "/" "_" group ${folder})
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

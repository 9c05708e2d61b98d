# Flags of all targets. The compiler may reassociate sums, so that neighbour loops vectorise, but not depending on the alignment of an
# address: results are bit-identical in every run, with any number of threads. NaN and infinity keep their meaning, because they show
# divergence.
add_library(whorl_flags INTERFACE)
target_compile_options(whorl_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wno-unknown-pragmas
  -fno-math-errno -fno-trapping-math -fno-signed-zeros -fassociative-math)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Disabled warnings: GCC 12 reports false ones inside std::string ("text" + string&&, GCC bug 105329), std::optional and its own AVX-512
  # header, and with a precompiled header it reports them in this project's files. The preset asan detects such faults instead.
  target_compile_options(whorl_flags INTERFACE --param=vect-max-peeling-for-alignment=0 -Wno-maybe-uninitialized -Wno-restrict -Wno-stringop-overflow
                         -Wno-stringop-overread -Wno-array-bounds -Wno-uninitialized)
endif()
if(WHORL_NATIVE)
  target_compile_options(whorl_flags INTERFACE -march=native)
else()  # a distributed program contains no path of the machine that built it
  target_compile_options(whorl_flags INTERFACE -fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=)
endif()
if(WHORL_WERROR)
  target_compile_options(whorl_flags INTERFACE -Werror)
endif()
if(WHORL_DOUBLE)
  target_compile_definitions(whorl_flags INTERFACE WHORL_DOUBLE)
endif()
if(WHORL_SANITIZE)
  # Without inlining, gcc warns that the ABI for returning the vectors of the viscous product depends on the target (-Wpsabi). The whole
  # build has one target.
  target_compile_options(whorl_flags INTERFACE -fsanitize=${WHORL_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1
                         -Wno-psabi)
  target_link_options(whorl_flags INTERFACE -fsanitize=${WHORL_SANITIZE})
endif()
# Code with little computation (reading scenes, the command line, tests) is optimised less, which halves its compile time. A target selects
# this with the property WHORL_COLD.
if(NOT CMAKE_BUILD_TYPE STREQUAL "Debug" AND NOT WHORL_SANITIZE)
  target_compile_options(whorl_flags INTERFACE $<IF:$<BOOL:$<TARGET_PROPERTY:WHORL_COLD>>,-O1,-O3>)
endif()

# Precompiles headers that nearly every source includes (two fifths of a target's compile time), and the headers ARGN.
function(precompile_headers target)
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  target_precompile_headers(${target} PRIVATE <Eigen/Core> <Eigen/Geometry> <algorithm> <cmath> <filesystem> <functional> <map> <memory> <optional>
                            <string> <variant> <vector> <fmt/format.h> ${ARGN})
endfunction()

# With CMAKE_UNITY_BUILD (set by the presets), the sources of a folder are compiled as one, so their headers are read once. Names in
# unnamed namespaces must therefore be unique within a folder.
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

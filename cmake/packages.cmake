# Dependencies, all from Debian 12 (tools/setup.sh installs them).
find_package(Threads REQUIRED)
find_package(OpenMP REQUIRED)
find_package(Eigen3 3.4 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(assimp REQUIRED IMPORTED_TARGET assimp)
pkg_check_modules(tinygltf REQUIRED IMPORTED_TARGET tinygltf)
pkg_check_modules(epoxy REQUIRED IMPORTED_TARGET epoxy)
pkg_check_modules(egl REQUIRED IMPORTED_TARGET egl)
pkg_check_modules(muparser REQUIRED IMPORTED_TARGET muparser)
# Debian builds cpp-httplib with TLS and compression, and its users must define both; the live view uses neither.
pkg_check_modules(httplib REQUIRED IMPORTED_TARGET cpp-httplib)
add_library(muparser::muparser ALIAS PkgConfig::muparser)

# Cairo draws text and plots, with a font that is embedded in the program.
pkg_check_modules(cairo REQUIRED IMPORTED_TARGET cairo-ft cairo-svg freetype2)
find_file(WHORL_FONT DejaVuSans.ttf PATHS /usr/share/fonts/truetype/dejavu REQUIRED)

# EXR images, for compositing.
pkg_check_modules(openexr REQUIRED IMPORTED_TARGET OpenEXR)

# stb writes PNG through zlib, ten times faster than with its own deflate. zlib also compresses particle files (.bgeo).
find_package(ZLIB REQUIRED)
find_path(STB_INCLUDE_DIR stb_image_write.h PATH_SUFFIXES stb REQUIRED)
add_library(stb INTERFACE)
target_include_directories(stb SYSTEM INTERFACE ${STB_INCLUDE_DIR})
target_link_libraries(stb INTERFACE ZLIB::ZLIB)

# OpenVDB's find module requires Python bindings, which are not needed here.
find_package(TBB REQUIRED)
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h REQUIRED)
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
add_library(openvdb INTERFACE)
target_include_directories(openvdb SYSTEM INTERFACE ${OPENVDB_INCLUDE_DIR})
target_link_libraries(openvdb INTERFACE ${OPENVDB_LIBRARY} TBB::tbb)

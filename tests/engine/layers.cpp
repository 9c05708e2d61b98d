// The arrows between the folders, read from the includes: docs/architecture.md says the same in words.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

const fs::path root = WHORL_SOURCE_DIR;

/// What each folder may include besides itself.
const std::map<std::string, std::set<std::string>> allowed = {
    {"engine/core", {}},
    {"engine/math", {"engine/core"}},
    {"engine/geometry", {"engine/core", "engine/math"}},
    {"engine/particles", {"engine/core", "engine/math", "engine/geometry"}},
    {"engine/sph", {"engine/core", "engine/math", "engine/geometry", "engine/particles"}},
    {"engine/models", {"engine/core", "engine/math", "engine/geometry", "engine/particles", "engine/sph"}},
    {"engine/scene", {"engine/core", "engine/math", "engine/geometry", "engine/particles", "engine/sph", "engine/models"}},
    {"engine/sim", {"engine/core", "engine/math", "engine/geometry", "engine/particles", "engine/sph", "engine/models", "engine/scene"}},
    {"engine/io",
     {"engine/core", "engine/math", "engine/geometry", "engine/particles", "engine/sph", "engine/models", "engine/scene", "engine/sim"}},
    {"render/image", {"engine/core"}},
    {"render/video", {"engine/core", "render/image"}},
    {"render/surface", {"engine/core", "engine/io/frame.h"}},
    {"render/look", {"engine/core", "engine/io/frame.h", "render/image"}},
    {"render/flow", {"engine/core", "engine/io/frame.h", "render/look"}},
    {"render/gl", {"engine/core", "engine/io/frame.h", "render/flow", "render/image", "render/look", "render/surface"}},
};

/// Libraries that only one folder may see.
const std::map<std::string, std::set<std::string>> kept_in = {
    {"openvdb/", {"render/surface"}}, {"EGL/", {"render/gl"}},     {"GL/", {"render/gl"}},
    {"epoxy/", {"render/gl"}},        {"stb_", {"render/image"}},  {"toml++/", {"engine/scene"}},
    {"muParser", {"engine/math"}},    {"httplib", {"tools"}},      {"CLI/", {"tools"}},
    {"tbb/", {"render/surface"}},     {"cairo", {"render/image"}}, {"ft2build", {"render/image"}},
};

std::string layer_of(const std::string& path) {
    for (const auto& [layer, may] : allowed)
        if (path.rfind(layer + "/", 0) == 0) return layer;
    return "";
}

struct Include {
    std::string from, what;
    bool own;
};

std::vector<Include> all_includes() {
    const std::regex pattern(R"(^\s*#include\s+([<"])([^>"]+)[>"])");
    std::vector<Include> found;
    for (const char* top : {"engine", "render", "tools"})
        for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".h" && extension != ".cpp") continue;
            std::ifstream in(entry.path());
            std::smatch match;
            for (std::string line; std::getline(in, line);)
                if (std::regex_search(line, match, pattern))
                    found.push_back({fs::relative(entry.path(), root).string(), match[2].str(), match[1].str() == "\""});
        }
    return found;
}

}  // namespace

TEST_CASE("no include points against the layers", "[layers]") {
    const auto includes = all_includes();
    REQUIRE(includes.size() > 50);
    for (const Include& include : includes) {
        const std::string from = layer_of(include.from);
        if (!include.own || from.empty()) continue;
        const std::string to = layer_of(include.what);
        const bool fine = to == from || allowed.at(from).count(to) > 0 || allowed.at(from).count(include.what) > 0;
        INFO(include.from << " includes " << include.what);
        CHECK(fine);
    }
}

TEST_CASE("each outside library is seen by one folder only", "[layers]") {
    for (const Include& include : all_includes())
        for (const auto& [library, folders] : kept_in) {
            if (include.own || include.what.rfind(library, 0) != 0) continue;
            bool fine = false;
            for (const std::string& folder : folders) fine = fine || include.from.rfind(folder + "/", 0) == 0;
            INFO(include.from << " includes " << include.what);
            CHECK(fine);
        }
}

// Dependencies between folders, read from the includes. docs/architecture.md describes them.
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

using Folders = std::set<std::string>;

Folders operator+(Folders a, const Folders& b) {
    a.insert(b.begin(), b.end());
    return a;
}

/// The other folders that each folder may include.
std::map<std::string, Folders> arrows() {
    const Folders core{"engine/core"}, math = core + Folders{"engine/math"}, geometry = math + Folders{"engine/geometry"},
                                       particles = geometry + Folders{"engine/particles"}, sph = particles + Folders{"engine/sph"},
                                       models = sph + Folders{"engine/models"}, scene = models + Folders{"engine/scene"},
                                       sim = scene + Folders{"engine/simulation"};
    const Folders frame = core + Folders{"engine/io/frame.h"};
    const Folders engine = sim + Folders{"engine/io", "engine/theory", "engine/probes"};
    const Folders render{"render/image", "render/video", "render/surface", "render/look", "render/flow", "render/export", "render/gl"};
    const Folders scene_file = engine + render + Folders{"tools/process", "tools/scene_file"};
    const Folders film = scene_file + Folders{"tools/cost", "tools/film"};
    return {
        {"engine/core", {}},
        {"engine/math", core},
        {"engine/geometry", math},
        {"engine/particles", geometry},
        {"engine/sph", particles},
        {"engine/models", sph},
        {"engine/scene", models},
        {"engine/simulation", scene},
        {"engine/io", sim},
        {"engine/theory", math},
        {"engine/probes", sim + Folders{"engine/io", "engine/theory"}},
        {"render/image", core},
        {"render/video", core + Folders{"render/image"}},
        {"render/surface", frame},
        {"render/look", frame + Folders{"render/image"}},
        {"render/flow", frame + Folders{"render/image", "render/look", "render/surface"}},
        {"render/export", frame + Folders{"engine/io/csv.h", "render/flow", "render/image", "render/look", "render/surface"}},
        {"render/gl", frame + Folders{"render/flow", "render/image", "render/look", "render/surface"}},
        {"tools/process", core + Folders{"render/video/process.h"}},
        {"tools/scene_file",
         sim + Folders{"engine/io/csv.h", "engine/io/byte_io.h", "render/image/image.h", "render/surface", "render/look", "tools/process"}},
        {"tools/cost", scene_file},
        {"tools/convert", geometry + Folders{"engine/io/csv.h", "render/surface"}},
        {"tools/film", scene_file + Folders{"tools/cost"}},
        {"tools/live", film},
        {"tools/study", scene_file},
        {"tools/farm", film},
        {"tools/program", film + Folders{"tools/convert", "tools/live", "tools/study", "tools/farm"}},
        {"tools/bench", engine + render + Folders{"tests/support"}},
        {"tools/measure", engine + Folders{"tests/support"}},
    };
}
const std::map<std::string, Folders> allowed = arrows();

/// Libraries that only one folder may include.
const std::map<std::string, std::set<std::string>> kept_in = {
    {"openvdb/", {"render/surface"}}, {"EGL/", {"render/gl"}},          {"GL/", {"render/gl"}},
    {"epoxy/", {"render/gl"}},        {"stb_", {"render/image"}},       {"toml++/", {"engine/scene"}},
    {"muParser", {"engine/math"}},    {"httplib", {"tools"}},           {"CLI/", {"tools"}},
    {"tbb/", {"render/surface"}},     {"cairo", {"render/image"}},      {"ft2build", {"render/image"}},
    {"OpenEXR/", {"render/image"}},   {"assimp/", {"engine/geometry"}}, {"tiny_gltf", {"engine/geometry"}},
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

TEST_CASE("no include violates the layers", "[layers]") {
    const auto includes = all_includes();
    REQUIRE(includes.size() > 50);
    for (const Include& include : includes) {
        const std::string from = layer_of(include.from);
        if (!include.own || from.empty()) continue;
        const std::string to = layer_of(include.what);
        const std::string folder = fs::path(include.what).parent_path().string();
        const bool fine =
            to == from || allowed.at(from).count(to) > 0 || allowed.at(from).count(include.what) > 0 || allowed.at(from).count(folder) > 0;
        INFO(include.from << " includes " << include.what);
        CHECK(fine);
    }
}

TEST_CASE("every folder with sources has a row of permitted folders", "[layers]") {
    for (const Include& include : all_includes()) {
        INFO(include.from);
        CHECK_FALSE(layer_of(include.from).empty());
    }
}

TEST_CASE("each external library is included by one folder only", "[layers]") {
    for (const Include& include : all_includes())
        for (const auto& [library, folders] : kept_in) {
            if (include.own || include.what.rfind(library, 0) != 0) continue;
            bool fine = false;
            for (const std::string& folder : folders) fine = fine || include.from.rfind(folder + "/", 0) == 0;
            INFO(include.from << " includes " << include.what);
            CHECK(fine);
        }
}

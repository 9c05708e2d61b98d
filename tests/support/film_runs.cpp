#include "tests/support/film_runs.h"

#include <algorithm>
#include <fstream>

#include "engine/io/csv.h"
#include "tests/support/scene_text.h"
#include "tests/support/scenes.h"

namespace whorl::test {

namespace fs = std::filesystem;

const std::string honey =
    little_honey("end = 0.3\nfps = 40", 2.5e-3,
                 text::block({-0.013, 0, -0.013}, {0.013, 0.025, 0.013}) + text::emitter({0, 0.045, 0}, 4e-3, 0.3) + R"([[solid]]
shape = "plane"
[[probe]]
name = "pile"
kind = "coil"
[[probe]]
name = "all"
kind = "region"
min = [-1, -1, -1]
max = [1, 1, 1]
)");

std::string falling_drop(int fps) {
    return text::time(0.1, "fps = " + std::to_string(fps)) + text::domain({-0.03, -0.01, -0.03}, {0.03, 0.06, 0.03}) +
           text::fluid(4e-3, 1) + text::models("ppe") + text::drop({0, 0.02, 0}, 0.012) + "[[solid]]\nshape = \"plane\"\n[output]\n";
}

FilmScratch::FilmScratch(const std::string& text) { std::ofstream(*this / "scene.toml") << text; }

Outcome FilmScratch::render(std::vector<std::string> more, const std::string& name) const {
    more.insert(more.begin(), {"render", scene(), "--quiet", "--out", run(name)});
    return succeed(more);
}

std::vector<std::string> lines(const fs::path& file) {
    std::vector<std::string> all;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
}

std::vector<std::string> reproducible(std::vector<std::string> rows) {
    for (std::string& row : rows) {
        std::size_t from = 0;
        for (int column = 1; column < 21; ++column) from = row.find(',', from) + 1;
        row.erase(from, row.find(',', row.find(',', from) + 1) - from);
    }
    return rows;
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> all;
    for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path());
    std::sort(all.begin(), all.end());
    return all;
}

nlohmann::json report(const fs::path& run) { return nlohmann::json::parse(read_whole(run / "run.json")); }

}  // namespace whorl::test

#include <fmt/format.h>

#include "engine/core/atomic_file.h"
#include "engine/scene/read.h"
#include "render/export/attributes.h"
#include "tools/convert/splishsplash.h"
#include "tools/program/command.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

struct ImportOptions {
    fs::path file, out;
};

/// Errors of the scene, or the warnings of its plan if it has no errors.
std::vector<std::string> remarks_on(const fs::path& scene) try {
    std::vector<std::string> lines;
    for (const std::string& warning : make_plan(read_scene_file(scene)).warnings) lines.push_back("warning: " + warning);
    return lines;
} catch (const InputError& error) {
    std::vector<std::string> lines;
    for (const Problem& problem : error.problems()) lines.push_back("to be fixed first: " + problem.message());
    return lines;
}

int import_scene(const ImportOptions& options) {
    const fs::path out = options.out.empty() ? fs::path(options.file.stem().string() + ".toml") : options.out;
    const ConvertedScene made = convert_splishsplash(options.file, scene_name(out));
    std::vector<fs::path> files{out};
    for (const auto& [name, mesh] : made.meshes) files.push_back(out.parent_path() / name);
    for (const fs::path& file : files)
        if (fs::exists(file)) throw InputError({file.string(), 0, 0}, "already exists", "move the file, or choose another name with --out");
    for (const auto& [name, mesh] : made.meshes) write_obj_mesh(out.parent_path() / name, mesh);
    write_text(out, made.toml);

    for (const Problem& note : made.notes) fmt::print("{}\n", note.message());
    for (const std::string& line : remarks_on(out)) fmt::print("{}\n", line);
    fmt::print("{} notes to check; the scene: {}\n", made.notes.size(), out.string());
    return exit_done;
}

}  // namespace

void add_import(CLI::App& program, Job& chosen) {
    const auto [app, o] =
        add_command(program, chosen, "import", "convert a SPlisHSPlasH scene (JSON), and report keys that have no equivalent", import_scene,
                    "Each note names a line of the SPlisHSPlasH scene.\n"
                    "Examples:\n"
                    "  whorl import DamBreak.json\n"
                    "  whorl import scenes/DamBreak.json --out my_scenes/dam.toml");
    app.add_option("file", o.file, "the SPlisHSPlasH scene")->required()->type_name("FILE.json");
    app.add_option("--out", o.out, "the scene file (default: FILE.toml in this folder); meshes go to the same folder")
        ->type_name("FILE.toml");
}

}  // namespace whorl
